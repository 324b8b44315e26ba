/* SPDX-License-Identifier: MIT
 *
 * What a detector makes of events: `reading`.
 */
#include "io/scene/scene_reading.h"

#include <string.h>

#include "io/scene/scene_keys.h"

/* Above 1 - 1/e an avalanche fires more than one other in the mean, and never ends. */
static const struct rmap_range crosstalk = {0, 0.6, "between 0 and 0.6", RMAP_DIMENSION_SHARE};
static const struct rmap_range cells = {1, 1e12, "a whole number from 1"};
static const struct rmap_range afterpulse = {0, 1, "between 0 and 1", RMAP_DIMENSION_SHARE};
const struct rmap_mapping rmap_afterpulse_keys = {
    "reading",
    NULL,
    {{"an afterpulse", "probability time"}},
    {{"probability", RMAP_KEY_NUMBER, offsetof(struct rmap_reading, afterpulse), &afterpulse},
     {"time", RMAP_KEY_NUMBER, offsetof(struct rmap_reading, afterpulse_ns), &rmap_range_delay}}};
const struct rmap_mapping rmap_reading_keys = {
    "reading",
    NULL,
    {{"a reading", "gain dark window crosstalk model afterpulse cells"}},
    {{"gain", RMAP_KEY_NUMBER, offsetof(struct rmap_reading, gain), &rmap_range_positive, 1},
     {"window", RMAP_KEY_NUMBER, offsetof(struct rmap_reading, window_ns), &rmap_range_delay},
     {"crosstalk", RMAP_KEY_NUMBER, offsetof(struct rmap_reading, crosstalk), &crosstalk},
     {"model", RMAP_KEY_WORD, offsetof(struct rmap_reading, model), .words = "borel geometric"},
     {"cells", RMAP_KEY_WHOLE, offsetof(struct rmap_reading, cells), &cells}}};

/* "100 kHz"; a number alone is in Hz. */
static void read_dark(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                      struct rmap_reading *reading)
{
    const char *text = rmap_reader_text(reader, node, "dark", RMAP_OPTIONAL), *unit = "";
    if (!text)
        return;
    const bool good = rmap_reader_parse_quantity(text, &reading->dark_hz, &unit);
    const double size = !good                                        ? 0
                        : unit[0] == '\0' || strcmp(unit, "Hz") == 0 ? 1
                        : strcmp(unit, "kHz") == 0                   ? 1e3
                        : strcmp(unit, "MHz") == 0                   ? 1e6
                                                                     : 0;
    reading->dark_hz *= size;
    if (!(size > 0) || !(reading->dark_hz >= 0 && reading->dark_hz <= 1e12))
        rmap_reader_error(reader, rmap_yaml_get(node, "dark"),
                          "'dark' must be a rate, as in '100 kHz' (Hz kHz MHz), not '%.40s'", text);
    else if (reading->dark_hz > 0 && !(reading->window_ns > 0))
        rmap_reader_error(reader, rmap_yaml_get(node, "dark"),
                          "'dark' counts are those of a 'window', as in 'window: 100 ns'");
}

void rmap_reader_reading(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                         struct rmap_detector *detector)
{
    const struct rmap_yaml_node *at = rmap_yaml_get(node, "reading");
    if (!at || !rmap_reader_known(reader, at, &rmap_reading_keys, 0))
        return;
    detector->reading.given = true;
    if (rmap_reader_fill(reader, at, &rmap_reading_keys, 0, &detector->reading))
        read_dark(reader, at, &detector->reading);
    const struct rmap_yaml_node *again = rmap_yaml_get(at, "afterpulse");
    if (again && rmap_reader_known(reader, again, &rmap_afterpulse_keys, 0) &&
        rmap_reader_fill(reader, again, &rmap_afterpulse_keys, 0, &detector->reading) &&
        !(rmap_yaml_get(again, "probability") && rmap_yaml_get(again, "time")))
        rmap_reader_error(reader, again,
                          "'afterpulse' has a probability and a mean delay, as in {probability: "
                          "3 %%, time: 20 ns}");
}
