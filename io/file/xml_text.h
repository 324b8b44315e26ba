/* SPDX-License-Identifier: MIT
 *
 * Text that may stand in XML and HTML.
 */
#ifndef RMAP_XML_TEXT_H
#define RMAP_XML_TEXT_H

#include <stddef.h>

/* Length in bytes of the valid UTF-8 character that begins there and may stand in XML (no control
 * characters but tab); 0: it is none. */
size_t rmap_xml_character_nbytes(const unsigned char *text);

/* What '&', '<', '>' and '"' are written as; NULL: any other character stands for itself. */
const char *rmap_xml_entity(char character);

#endif
