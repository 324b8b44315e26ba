/* SPDX-License-Identifier: MIT
 *
 * A session's map as it is on disk by now.
 */
#include "mpi/session/session_refresh.h"

#include <stdio.h>

#include "base/grouped.h"
#include "io/map/map_content.h"
#include "io/map/map_json.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/parallel/agree.h"

static enum rmap_status tell(const struct rmap_session *session, uint64_t before,
                             struct rmap_error *err)
{
    const uint64_t rays = rmap_map_contents(session->map)->n_row[RMAP_TABLE_RAY];
    if (session->context->json)
        return rmap_json_line(
            rmap_json_of_map(json_pack("{s:{s:I, s:I}}", "refreshed", "rays_before",
                                       (json_int_t)before, "rays", (json_int_t)rays),
                             session->map),
            stdout, err);
    printf("%s, %s before\n", rmap_counted(rays, "ray").text, rmap_counted(before, "ray").text);
    return RMAP_OK;
}

enum rmap_status rmap_session_refresh(struct rmap_session *session, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map *now = NULL;
    const uint64_t before = rmap_map_contents(session->map)->n_row[RMAP_TABLE_RAY];
    if (rmap_load_map(session->context, session->path, &now, err) != RMAP_OK) {
        rmap_error_context(err, "refresh: the map is as it was to this session");
        return err->status = RMAP_INPUT;
    }
    rmap_map_close(session->map);
    session->map = now;
    rmap_session_memo_clear(&session->memo);
    session->warm = false;
    if (session->context->rank == 0)
        st = tell(session, before, err);
    return rmap_agree(session->context, st, err);
}
