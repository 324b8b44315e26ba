/* SPDX-License-Identifier: MIT
 *
 * Readers of lamp makers' files and what they share: the grid of intensities, as it stands in the
 * file and with the file's symmetries written out.
 */
#ifndef RMAP_LAMP_READER_H
#define RMAP_LAMP_READER_H

#include <stdbool.h>

#include "io/lamp/lamp_file.h"

struct rmap_lamp_text {
    const char *at, *end;
    size_t line;
    bool commas; /* numbers end with their line and may have a decimal comma */
};

struct rmap_lamp_range {
    double low, high;
    bool whole;
};

enum rmap_status rmap_lamp_ies_read(struct rmap_lamp_text *scan,
                                    const struct rmap_lamp_choice *choice,
                                    struct rmap_lamp_file *file,
                                    struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_lamp_eulumdat_read(struct rmap_lamp_text *scan,
                                         const struct rmap_lamp_choice *choice,
                                         struct rmap_lamp_file *file,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* The next line and its length without the blanks at its end. */
size_t rmap_lamp_line(struct rmap_lamp_text *scan, const char **line);

/* The next number. RMAP_INPUT with the line. */
enum rmap_status rmap_lamp_number(struct rmap_lamp_text *scan, const char *what,
                                  const struct rmap_lamp_range *range, double *value,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* Room for the file's grid, all 0. RMAP_SYSTEM. */
enum rmap_status rmap_lamp_grid(struct rmap_lamp_file *file, size_t n_around, size_t n_polar,
                                struct rmap_error *err) RMAP_MUST_USE;

/* Polar angles go from 90 on: what they have is repeated below 90. */
enum rmap_status rmap_lamp_mirror_polar(struct rmap_lamp_file *file,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* How the angles around, of any order, fill the turn. */
enum rmap_lamp_turn {
    RMAP_LAMP_AS_IT_IS = 0,
    RMAP_LAMP_MIRROR_0 = 1,  /* repeated across the plane of 0 and 180 */
    RMAP_LAMP_MIRROR_90 = 2, /* across that of 90 and 270 */
    RMAP_LAMP_DARK = 4       /* they ascend, and where they do not reach is no light */
};

/* Angles around written out, from 0 to 360. RMAP_SYSTEM. */
enum rmap_status rmap_lamp_write_out(struct rmap_lamp_file *file, unsigned turn,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* Ascending angles around [n] leave no larger gap in the turn than there is between them. */
bool rmap_lamp_is_whole_turn(const double *around_deg, size_t n);

/* Adds words of the file, UTF-8 or else Latin-1, to the title as far as it has room. */
void rmap_lamp_title(struct rmap_lamp_file *file, const char *text, size_t nbytes);

#endif
