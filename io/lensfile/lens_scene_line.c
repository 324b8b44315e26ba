/* SPDX-License-Identifier: MIT
 *
 * From a line of the scene back to the surface of the lens.
 */
#include <stdio.h>
#include <string.h>

#include "io/lensfile/lens_scene.h"

static const char *begin_of(const char *text, int line)
{
    for (; text && line > 1; line--) {
        text = strchr(text, '\n');
        text = text ? text + 1 : NULL;
    }
    return text;
}

/* "   # 3: words" behind what stands there. */
static bool by_remark(const struct rmap_lens_plan *plan, const char *begin, size_t *at)
{
    const char *end = begin + strcspn(begin, "\n"), *mark = strstr(begin, "   # ");
    int number = 0;
    if (!mark || mark >= end || sscanf(mark + 5, "%d", &number) != 1)
        return false;
    for (*at = 1; *at < plan->lens->n_surface; ++*at)
        if (plan->lens->surface[*at].number == number)
            return true;
    return false;
}

bool rmap_lens_scene_line(const struct rmap_lens_plan *plan, const char *text, int line, size_t *at)
{
    const char *begin = line > 0 ? begin_of(text, line) : NULL;
    if (!begin)
        return false;
    if (by_remark(plan, begin, at))
        return true;
    begin += strspn(begin, " ");
    begin += strncmp(begin, "- {name: ", 9) == 0 ? 9 : 0;
    const size_t n = strcspn(begin, ":,\n");
    for (size_t e = 0; e < plan->n_element; e++)
        if (strlen(plan->element[e].name) == n && strncmp(plan->element[e].name, begin, n) == 0) {
            *at = plan->row[plan->element[e].first].surface;
            return true;
        }
    return false;
}
