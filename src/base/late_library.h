/* SPDX-License-Identifier: MIT
 *
 * Libraries that few commands need are loaded by who needs them. Linked, each would cost every
 * start of the program, on every rank, 3 to 15 ms of processor time.
 *
 *     #define XML(X) X(xmlNewParserCtxt) X(xmlFreeDoc)
 *     struct xml { XML(RMAP_LATE_MEMBER) };
 *     static const char *const xml_name[] = {XML(RMAP_LATE_NAME)};
 */
#ifndef RMAP_LATE_LIBRARY_H
#define RMAP_LATE_LIBRARY_H

#include <stddef.h>

#include "base/status.h"

#define RMAP_LATE_MEMBER(function) __typeof__(&(function)) function;
#define RMAP_LATE_NAME(function)   #function,

/* Finds `n` functions by name and puts their addresses, in this order, to `functions`: a struct of
 * nothing but `n` pointers to functions. The library stays loaded; asking again is cheap.
 * soname: as the build found it (cmake/Dependencies.cmake); need: what is needed of it, for the
 * message ("XML is read by libxml2"). RMAP_SYSTEM if it cannot be loaded. */
enum rmap_status rmap_late_library(const char *soname, const char *need, const char *const *name,
                                   size_t n, void *functions, struct rmap_error *err) RMAP_MUST_USE;

#endif
