# SPDX-License-Identifier: MIT
#
# A Slurm of our own on this machine: slurmctld, slurmd and munged with their configuration, keys,
# sockets and logs in one directory, one node of 4 CPUs, started and stopped by the test. Nothing of
# the system's own Slurm is read or touched.
#
#   slurm_up DIRECTORY     0 and SLURM_CONF exported once the node is idle
#   slurm_down             ends the three daemons

PATH=$PATH:/usr/sbin:/sbin # where Debian has daemons; a user does not look there

slurm_missing() { # the first command that is not here, or nothing
    local command
    for command in munged slurmctld slurmd sbatch scontrol squeue scancel sinfo; do
        command -v $command >/dev/null || { echo $command; return; }
    done
}

slurm_free_port() {
    local port
    while port=$((20000 + RANDOM % 12000)); do
        (exec 3<>"/dev/tcp/127.0.0.1/$port") 2>/dev/null || { echo $port; return; }
    done
}

slurm_write_conf() { # DIRECTORY
    local host user
    host=$(hostname -s)
    user=$(id -un)
    cat <<CONF
ClusterName=raymaptest
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$(slurm_free_port)
SlurmUser=$user
SlurmdUser=$user
AuthType=auth/munge
AuthInfo=socket=$1/munge.socket
CredType=cred/munge
StateSaveLocation=$1/state
SlurmdSpoolDir=$1/spool
SlurmctldPidFile=$1/slurmctld.pid
SlurmdPidFile=$1/slurmd.pid
SlurmctldLogFile=$1/slurmctld.log
SlurmdLogFile=$1/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/none
SchedulerType=sched/builtin
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
SwitchType=switch/none
MpiDefault=none
ReturnToService=2
JobRequeue=1
MinJobAge=600
KillWait=5
NodeName=node1 NodeHostname=$host NodeAddr=127.0.0.1 Port=$(slurm_free_port) CPUs=4 RealMemory=1000 State=UNKNOWN
PartitionName=batch Nodes=ALL Default=YES MaxTime=60 State=UP
CONF
}

slurm_up() { # DIRECTORY, short: sockets have short names
    SLURM_DIRECTORY=$1
    local d=$1 i
    # Nothing stays behind, even where this shell is killed.
    (
        trap '' INT TERM HUP
        while kill -0 $$ 2>/dev/null; do sleep 1; done
        slurm_down
        rm -rf "$d"
    ) >/dev/null 2>&1 </dev/null &
    mkdir -p "$d/state" "$d/spool" "$d/munge"
    chmod 700 "$d/munge"
    head -c 1024 /dev/urandom >"$d/munge/key"
    chmod 600 "$d/munge/key"
    munged --force --key-file="$d/munge/key" --socket="$d/munge.socket" --pid-file="$d/munged.pid" \
        --log-file="$d/munge/log" --seed-file="$d/munge/seed" || return 1
    slurm_write_conf "$d" >"$d/slurm.conf"
    export SLURM_CONF="$d/slurm.conf"
    slurmctld -c -f "$SLURM_CONF" && slurmd -N node1 -f "$SLURM_CONF" || return 1
    for ((i = 0; i < 100; i++)); do
        [ "$(sinfo -h -N -t idle 2>/dev/null | wc -l)" -ge 1 ] && return 0
        sleep 0.1
    done
    return 1
}

slurm_down() {
    local daemon pid i
    [ -n "${SLURM_DIRECTORY:-}" ] || return 0
    scancel --user="$(id -un)" 2>/dev/null
    for daemon in slurmd slurmctld munged; do
        pid=$(cat "$SLURM_DIRECTORY/$daemon.pid" 2>/dev/null) || continue
        kill "$pid" 2>/dev/null
        for ((i = 0; i < 100; i++)); do
            [ -e "/proc/$pid/exe" ] || break
            sleep 0.1
        done
    done
}
