/* SPDX-License-Identifier: MIT
 *
 * What a process that was started under this preload library is told to suffer.
 *
 * Calls that touch files at or below FAULTS_DIR are counted from 1, and at the chosen one something
 * happens. All of it is said by environment variables, so that the program under test is the very
 * program that users run:
 *
 *   FAULTS_DIR     the directory, absolute, without links (without it nothing is counted)
 *   FAULTS_CALLS   shell patterns of the calls that count, by commas (default "*": the calls that
 *                  change files). Reading calls are "read:open", "read:pread", ...; memory asked
 *                  for by the program itself "memory:calloc", ..., threads started by anything
 *                  "thread:pthread_create"; HDF5 functions have their
 *                  own names
 *   FAULTS_PATH    shell pattern that the path must match too (default "*")
 *   FAULTS_RANK    only in this rank of MPI (default: in each, and each counts for itself)
 *   FAULTS_AT      number of the call (default 0: count only)
 *   FAULTS_ACTION  ENOSPC, EIO, EAGAIN, EDQUOT, ENOMEM, EINTR, EACCES, EMFILE, ENOLCK: the call
 * fails so; kill: SIGKILL before the call; tear: SIGKILL after half of what it writes; exit: _exit
 * before the call; short: half is written, and said so; stop: SIGSTOP before the call, which is
 * made once somebody sends SIGCONT; SIGUSR1: the signal before the call, which is made
 *   FAULTS_STICKY  1: every later call that counts fails too
 *   FAULTS_LEAKS   file of how many blocks of memory the program itself asked for and never gave
 *                  back, ".RANK" appended, and where it had some of them from
 *   FAULTS_LOG     file of a line "NUMBER CALL PATH" per counted call, ".RANK" appended
 *   FAULTS_RECORD  file of all changes with their bytes (fault_record.h), ".RANK" appended
 */
#ifndef FAULT_PLAN_H
#define FAULT_PLAN_H

#include <stdbool.h>
#include <stddef.h>

enum fault_outcome { FAULT_NONE, FAULT_ERROR, FAULT_SHORT, FAULT_TEAR };

/* Room for a path of /proc/self/fd. */
enum { FAULT_PATH_CAP = 4096 };

/* Whether a path, absolute or from the working directory, lies at or below FAULTS_DIR. */
bool fault_watches(const char *path);

/* The same for an open file, whose path is written to path[FAULT_PATH_CAP]. */
bool fault_watches_file(int fd, char *path);

/* Counts a call and says what is to happen to it. FAULT_ERROR: errno is set, the call returns its
 * error value. FAULT_SHORT, FAULT_TEAR: for calls that write. Does not return when it is time to
 * die. Thread-safe; keeps errno otherwise. */
enum fault_outcome fault_decide(const char *call, const char *path);

/* SIGKILL to this process. */
_Noreturn void fault_die(void);

/* Whether an address lies in the program itself, not in a library. */
bool fault_in_program(const void *address);

/* Opens FAULTS_LOG, FAULTS_RECORD or FAULTS_LEAKS for this rank; -1 where it is not asked for. */
int fault_open_output(const char *variable);

#endif
