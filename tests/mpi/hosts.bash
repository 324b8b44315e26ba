# SPDX-License-Identifier: MIT
#
# Hosts of our own on this machine: each has its processes, its network (on a bridge, TCP between
# them), its name and its shared memory; the file system is common, as on a cluster. All is inside
# namespaces of the test, which end with it.
#
#   hosts_enter "$0"       runs the script anew in namespaces, once; exits 77 where there are none
#   hosts_up N             makes h1 ... hN
#   $HOSTS_FOLDER/mpirun H:N,... PROGRAM...   N ranks on each host, the launcher beside them
#   hosts_cut H, hosts_heal H         takes a host from the network, and brings it back
#   hosts_kill H           all its processes die at once

hosts_enter() {
    [ -z "${HOSTS_FOLDER:-}" ] || return 0
    local command as_root=()
    for command in unshare nsenter ip mount pgrep mpirun; do
        command -v $command >/dev/null || { echo "no $command here"; exit 77; }
    done
    [ "$(id -u)" -eq 0 ] || as_root=(--user --map-root-user)
    local enter=(unshare "${as_root[@]}" --net --mount --pid --fork --kill-child --mount-proc)
    "${enter[@]}" unshare --net --uts --ipc --mount mount -t tmpfs none /mnt 2>/dev/null ||
        { echo "namespaces are not allowed here"; exit 77; }
    unset HWLOC_COMPONENTS PMIX_MCA_gds # of ranks beside each other (tests/CMakeLists.txt)
    HOSTS_FOLDER=$(mktemp -d) # short: names of sockets have 100 letters
    export HOSTS_FOLDER OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 # as it is there
    "${enter[@]}" bash "$1"
    local status=$?
    rm -rf "$HOSTS_FOLDER"
    exit $status
}

hosts_up() {
    local i pid
    ip link set lo up
    ip link add bridge type bridge
    ip addr add 10.77.0.254/24 dev bridge
    ip link set bridge up
    echo '127.0.0.1 localhost' >"$HOSTS_FOLDER/hosts"
    for ((i = 1; i <= $1; i++)); do echo "10.77.0.$i h$i" >>"$HOSTS_FOLDER/hosts"; done
    mount --bind "$HOSTS_FOLDER/hosts" /etc/hosts
    for ((i = 1; i <= $1; i++)); do
        rm -f "$HOSTS_FOLDER/h$i"
        unshare --fork --kill-child --pid --mount-proc --uts --net --mount --ipc bash -c "
            hostname h$i; mount -t tmpfs none /dev/shm; ip link set lo up
            trap '' CHLD; echo >'$HOSTS_FOLDER/h$i.up'; exec sleep 3600" &
        until [ -e "$HOSTS_FOLDER/h$i.up" ] && pid=$(pgrep -P $! sleep); do sleep 0.02; done
        echo "$pid" >"$HOSTS_FOLDER/h$i"
        rm "$HOSTS_FOLDER/h$i.up"
        ip link add "v$i" type veth peer name eth0 netns "$pid"
        ip link set "v$i" master bridge up
        nsenter -t "$pid" -n ip addr add "10.77.0.$i/24" dev eth0
        nsenter -t "$pid" -n ip link set eth0 up
    done
    cat >"$HOSTS_FOLDER/rsh" <<'RSH'
#!/bin/sh
while [ "${1#-}" != "$1" ]; do shift; done
host=$1; shift
exec nsenter -t "$(cat "$HOSTS_FOLDER/$host")" -n -u -m -p -i -- /bin/sh -c "$*"
RSH
    # Only what a person says who starts ranks on other hosts: which, how to get there, which network.
    cat >"$HOSTS_FOLDER/mpirun" <<'RUN'
#!/bin/bash
unset "${!OMPI_MCA_@}"
hosts=$1
shift
exec mpirun --host "$hosts" --mca plm_rsh_agent "$HOSTS_FOLDER/rsh" \
    --mca btl_tcp_if_include 10.77.0.0/24 --mca oob_tcp_if_include 10.77.0.0/24 "$@"
RUN
    chmod +x "$HOSTS_FOLDER/rsh" "$HOSTS_FOLDER/mpirun"
}

hosts_cut() { ip link set "v${1#h}" down; }
hosts_heal() { ip link set "v${1#h}" up; }
hosts_kill() { kill -9 "$(cat "$HOSTS_FOLDER/$1")"; }
