/* SPDX-License-Identifier: MIT
 *
 * A stream struct for ISA-L's compressor, placed so that equal input gives equal bytes.
 *
 * The level 1 search of ISA-L (2.30 and later, igzip_icf_body_h1_gr_bt.asm, .write_first_byte)
 * files position 2 of each input not under the hash of its bytes but under the hash of a register
 * that nothing has loaded: bits 16 to 47 of the address of the stream struct. The matches found
 * are right wherever it lies, but which ones are found changes with it, so from run to run. Here
 * every stream lies where that hash is 0.
 */
#ifndef RMAP_IGZIP_STREAM_H
#define RMAP_IGZIP_STREAM_H

struct isal_zstream;

/* Zeroed; NULL when memory is short. Where the system leaves no such place free (it does on Linux,
 * with its own memory checkers too), a stream elsewhere: good for all but equal bytes.
 * owner: whoever will hold the stream; its address alone is used, to begin the search. */
struct isal_zstream *rmap_igzip_stream_create(const void *owner);
void rmap_igzip_stream_destroy(struct isal_zstream *stream); /* NULL is fine */

#endif
