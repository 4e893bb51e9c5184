#!/bin/sh
# What the tests need of Slurm: jobs are counted from 1, tasks run within sbatch, and the collecting
# job a second later. Its state lies in the folder `state` beside it:
#   held        tasks of that job number never run, and squeue says so until they are cancelled
#   lost        every task ends without having done anything
#   queue/      what squeue prints, a file for each job
#   number, submitted, cancelled, log    what was asked for, and what jobs printed
state=$(dirname "$0")/state
mkdir -p "$state/queue"
case ${0##*/} in
scontrol) echo "MaxArraySize            = 1001" ;;
squeue) cat "$state"/queue/* 2>/dev/null || true ;;
scancel)
    echo "$*" >>"$state/cancelled"
    for task; do rm -f "$state/queue/${task%%_*}"; done
    ;;
sbatch)
    number=$(($(cat "$state/number" 2>/dev/null || echo 0) + 1))
    echo "$number" >"$state/number"
    array= script= offset=
    for word; do
        case $word in
        --array=*) array=${word#--array=} ;;
        *.sh) script=$word ;;
        esac
        offset=$word
    done
    echo "$number${array:+ $array}" >>"$state/submitted"
    if [ -z "$array" ]; then
        echo "$number|PENDING|Dependency" >"$state/queue/$number"
        # Behind what it depends on, as in Slurm.
        (
            while ls "$state"/queue/array-* >/dev/null 2>&1; do sleep 0.1; done
            sleep 1
            SLURM_JOB_ID=$number sh "$script"
            rm -f "$state/queue/$number"
        ) >>"$state/log" 2>&1 &
    else
        for run in $(echo "$array" | tr , ' '); do
            for task in $(seq "${run%-*}" "${run#*-}"); do
                [ -e "$state/lost" ] && continue
                SLURM_JOB_ID=$number SLURM_ARRAY_TASK_ID=$task bash "$script" "$offset"
            done
        done >>"$state/log" 2>&1
    fi
    echo "$number"
    ;;
esac
