/* SPDX-License-Identifier: MIT
 *
 * Files on their way to the disk.
 */
#ifndef RMAP_WRITE_BACK_H
#define RMAP_WRITE_BACK_H

/* Asks the system to begin writing to disk what the file was given so far, without waiting: who
 * syncs it later waits less. Nothing is promised, errors are the later sync's to tell. */
void rmap_write_back_begin(int fd);

#endif
