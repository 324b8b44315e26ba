/* SPDX-License-Identifier: MIT
 *
 * The two-level scene: its structure and the devices of Embree.
 */
#include <stdio.h>
#include <string.h>

#include "accel/accel.h"
#include "accel/accel_bottom.h"
#include "accel/accel_build.h"
#include "accel/accel_internal.h"
#include "accel/accel_joint.h"
#include "base/alloc.h"
#include "base/grouped.h"
#include "base/workers.h"

/* As Embree's configuration spells them, worst first, and as people do. */
static const char *const isa_config[] = {"sse2", "sse4.2", "avx", "avx2", "avx512"};
static const char *const isa_name[] = {"SSE2", "SSE4.2", "AVX", "AVX2", "AVX-512"};
enum { N_ISA = sizeof(isa_config) / sizeof(isa_config[0]), WIDE_ISA = 3 };

static RTCDevice open_device(int n_threads, int level)
{
    char config[64];
    (void)snprintf(config, sizeof(config), "threads=%d,isa=%s", n_threads, isa_config[level]);
    return rtcNewDevice(config);
}

int rmap_accel_isa_level(void)
{
    for (int level = N_ISA - 1; level >= 0; level--) {
        RTCDevice device = open_device(1, level);
        if (device) {
            rtcReleaseDevice(device);
            return level;
        }
        /* Short of memory Embree keeps a lock, which it would wait for at its next device. */
        if (rtcGetDeviceError(NULL) != RTC_ERROR_UNSUPPORTED_CPU)
            break;
    }
    return -1;
}

int rmap_accel_isa_level_of(const char *name)
{
    int level = N_ISA - 1;
    while (level >= 0 && strcmp(isa_name[level], name) != 0)
        level--;
    return level;
}

const char *rmap_accel_isa(const struct rmap_accel *accel)
{
    return isa_name[accel->device->level];
}

bool rmap_accel_is_wide(const struct rmap_accel *accel)
{
    return accel->device->level >= WIDE_ISA;
}

const char *rmap_accel_embree_version(void)
{
    return RTC_VERSION_STRING;
}

/* Embree reports from whichever thread builds; the first report counts. */
static void on_error(void *user, enum RTCError code, const char *text)
{
    struct rmap_accel_failure *failure = user;
    if (atomic_flag_test_and_set(&failure->taken))
        return;
    failure->code = code;
    (void)snprintf(failure->text, sizeof(failure->text), "%s", text ? text : "");
}

enum rmap_status rmap_accel_failed(struct rmap_accel *accel, const char *doing,
                                   struct rmap_error *err)
{
    const struct rmap_accel_failure *failure = &accel->device->failure;
    if (failure->code == RTC_ERROR_NONE)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_SYSTEM, "Embree failed while %s: %s (error %d)", doing,
                          failure->text, (int)failure->code);
}

static enum rmap_status accel_open(struct rmap_accel *accel, int n_threads, int level,
                                   struct rmap_error *err)
{
    if (level < 0 || level >= N_ISA)
        return rmap_error_set(
            err, RMAP_SYSTEM,
            "Embree has no memory for a device, or knows no instruction set of this "
            "machine");
    struct rmap_accel_device *device = rmap_alloc(1, sizeof(*device));
    if (!device)
        return rmap_error_set(err, RMAP_SYSTEM, "no memory for the structure of the scene");
    accel->device = device;
    device->level = level;
    device->embree = open_device(n_threads, level);
    if (!device->embree)
        return rmap_error_set(err, RMAP_SYSTEM, "Embree gives no device for %s (error %d)",
                              isa_name[level], (int)rtcGetDeviceError(NULL));
    atomic_flag_clear(&device->failure.taken);
    rtcSetDeviceErrorFunction(device->embree, on_error, &device->failure);
    return RMAP_OK;
}

/* Embree builds with threads of TBB, which ends the process where it cannot start one. */
static enum rmap_status try_threads(int n_threads, struct rmap_error *err)
{
    const int most = rmap_workers_available();
    const int n = (n_threads > 0 && n_threads < most ? n_threads : most) - 1;
    if (n <= 0 || rmap_workers_can_start(n))
        return RMAP_OK;
    return rmap_error_set(err, RMAP_SYSTEM,
                          "cannot start %s to help to build the scene: give it more memory or "
                          "processes (ulimit -v, -u), or fewer --threads",
                          rmap_counted((uint64_t)n, "thread").text);
}

enum rmap_status rmap_accel_create_isa(const struct rmap_scene *scene, int n_threads, int level,
                                       struct rmap_accel **accel_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_accel *accel = rmap_alloc(1, sizeof(*accel));
    if (!accel)
        return rmap_error_set(err, RMAP_SYSTEM, "no memory for the structure of the scene");
    RMAP_TRY(try_threads(n_threads, err));
    RMAP_TRY(accel_open(accel, n_threads, level, err));
    RMAP_TRY(rmap_accel_build(accel, scene, NULL, err));
    *accel_ret = accel;
    return RMAP_OK;
out:
    rmap_accel_destroy(accel);
    return st;
}

enum rmap_status rmap_accel_create(const struct rmap_scene *scene, int n_threads,
                                   struct rmap_accel **accel_ret, struct rmap_error *err)
{
    return rmap_accel_create_isa(scene, n_threads, rmap_accel_isa_level(), accel_ret, err);
}

/* A failure of before is nobody's. */
static void forget_failure(struct rmap_accel_device *device)
{
    device->failure.code = RTC_ERROR_NONE;
    atomic_flag_clear(&device->failure.taken);
}

enum rmap_status rmap_accel_create_like(const struct rmap_accel *like,
                                        const struct rmap_scene *scene,
                                        struct rmap_accel **accel_ret, struct rmap_error *err)
{
    struct rmap_accel *accel = rmap_alloc(1, sizeof(*accel));
    if (!accel)
        return rmap_error_set(err, RMAP_SYSTEM, "no memory for the structure of the scene");
    accel->device = like->device;
    accel->device->n_more++;
    forget_failure(accel->device);
    const enum rmap_status st = rmap_accel_build(accel, scene, like, err);
    if (st != RMAP_OK)
        rmap_accel_destroy(accel);
    else
        *accel_ret = accel;
    return st;
}

enum rmap_status rmap_accel_move(struct rmap_accel *accel, const int32_t *object, size_t n_object,
                                 struct rmap_error *err)
{
    forget_failure(accel->device);
    return rmap_accel_rebuild(accel, object, n_object, err);
}

enum rmap_status rmap_accel_settle(struct rmap_accel *accel, struct rmap_error *err)
{
    forget_failure(accel->device);
    return accel->moved.n > 0 ? rmap_accel_rebuild(accel, NULL, 0, err) : RMAP_OK;
}

const struct rmap_accel_build *rmap_accel_last_build(const struct rmap_accel *accel)
{
    return &accel->build;
}

static void device_drop(struct rmap_accel_device *device)
{
    if (!device || device->n_more-- > 0)
        return;
    if (device->embree)
        rtcReleaseDevice(device->embree);
    rmap_free(device);
}

void rmap_accel_destroy(struct rmap_accel *accel)
{
    if (!accel)
        return;
    rmap_accel_release_top(accel);
    rmap_bottoms_release(accel);
    device_drop(accel->device);
    rmap_joints_release(accel);
    rmap_free(accel->object);
    rmap_free(accel->box);
    rmap_free(accel);
}
