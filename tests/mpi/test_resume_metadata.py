# SPDX-License-Identifier: MIT
"""The promise: --resume asks little of the file system: 20 calls that name files of the map by each rank and 10 for
each shard in all, and 20 more for each unfinished piece that a killed rank left, of which it makes a finished
one. On a cluster thousands of ranks meet thousands of shards, and one server answers all of them."""
import glob
import os
import re
import shutil
import subprocess
import sys
import time

PROGRAM = os.environ["RAYMAP"]
HERE = os.path.dirname(os.path.abspath(__file__))
CALLS = ("open,openat,creat,stat,lstat,newfstatat,statx,access,faccessat,faccessat2,readlink,readlinkat,"
         "getdents,getdents64,unlink,unlinkat,link,linkat,symlink,symlinkat,rename,renameat,renameat2,"
         "mkdir,mkdirat,rmdir,chmod,fchmodat,truncate,utimensat")
PER_RANK, PER_SHARD, PER_LEFTOVER = 20, 10, 20
TRACE = ["trace", "scene.yaml", "-n", "1G", "--quiet", "--threads", "1", "-o"]


def launched(ranks, *before):
    return ["mpirun", "-np", str(ranks), *before, PROGRAM]


def stop(path, ranks):
    """By its time limit, once the first shard has a piece: a loaded machine needs longer."""
    limit = 0.3
    while not glob.glob(f"{path}/shard-00000/piece-*.h5"):
        shutil.rmtree(path, ignore_errors=True)
        done = subprocess.run([*launched(ranks), *TRACE, path, "--time-limit", f"{limit}s"], capture_output=True,
                              text=True, timeout=120, check=False)
        assert done.returncode == 6 and limit < 60, done.stderr
        limit *= 2


def kill(path, ranks):
    """Once each rank has made something safe, all die at a blow."""
    with subprocess.Popen([*launched(ranks), *TRACE, path, "--flush-portions", "1"], stdout=subprocess.DEVNULL,
                          stderr=subprocess.DEVNULL) as job:
        until = time.monotonic() + 60
        while len(glob.glob(f"{path}/shard-*/.piece-*.journal")) < ranks and time.monotonic() < until:
            time.sleep(0.05)
        pids = subprocess.run(["ps", "-o", "pid=", "--ppid", str(job.pid)], capture_output=True, text=True,
                              check=True).stdout.split()
        for pid in pids:
            os.kill(int(pid), 9)
        job.wait(timeout=60)


def calls_within(path, log):
    """What strace wrote of one rank; fstat looks like a newfstatat without a name."""
    with open(log, encoding="utf-8", errors="replace") as file:
        return [line for line in file if re.match(r"\d+ +\w+\(", line) and path in line
                and '"", ' not in line]


def count(base, ranks):
    shutil.rmtree("again.raymap", ignore_errors=True)
    shutil.copytree(base, "again.raymap")
    for log in glob.glob("calls.*"):
        os.remove(log)
    traced = f'exec strace -f -qq -y -s 999 -e trace={CALLS} -o calls.$OMPI_COMM_WORLD_RANK "$@"'
    done = subprocess.run([*launched(ranks, "sh", "-c", traced, "sh"), *TRACE, "again.raymap", "--resume",
                           "--time-limit", "0.3s", "--flush", "1h"], capture_output=True, text=True, timeout=120,
                          check=False,
                          env={**os.environ, "ASAN_OPTIONS": "detect_leaks=0"})  # not under ptrace
    assert done.returncode == 6, done.stderr
    return [calls_within("again.raymap", f"calls.{rank}") for rank in range(ranks)]


if not shutil.which("mpirun") or not shutil.which("strace") or subprocess.run(
        ["strace", "-o", "/dev/null", "true"], capture_output=True, check=False).returncode != 0:
    print("mpirun or strace is not here, or may not trace")
    sys.exit(77)
subprocess.run(["bash", "-c", '. "$0"; write_scene scene.yaml', f"{HERE}/../cli/expect.bash"], check=True)
failures = 0
for end, shards, numbers in ((stop, 2, (1, 4)), (stop, 8, (4,)), (kill, 8, (4,))):
    shutil.rmtree("base.raymap", ignore_errors=True)
    end("base.raymap", shards)
    left = len(glob.glob("base.raymap/shard-*/.piece-*.journal"))
    assert len(glob.glob("base.raymap/shard-*")) == shards
    for n_rank in numbers:
        calls = count("base.raymap", n_rank)
        total, most = sum(map(len, calls)), max(map(len, calls[1:]), default=0)
        bound = PER_RANK * n_rank + PER_SHARD * shards + PER_LEFTOVER * left
        print(f"{shards} shards, {left} unfinished, {n_rank} ranks: {total} calls, at most {bound};",
              f"by a rank but the first: {most}", flush=True)
        if total > bound or left == 0 and most > PER_RANK:
            failures += 1
            print("FAILED:", *(line for rank in calls for line in rank), sep="\n")
sys.exit(1 if failures else 0)
