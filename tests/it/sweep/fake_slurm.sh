#!/bin/sh
# What the tests need of Slurm: jobs are counted from 1, tasks run within sbatch, and the collecting
# job a second after nothing that it depends on waits any more. Its state lies in the folder `state`
# beside it:
#   held        tasks of the first job never run, and squeue says so until they are cancelled
#   lost        every task ends without having done anything
#   silent      the program of that name does not answer
#   queue/      what squeue prints, a file for each job
#   number, submitted, cancelled, log    what was asked for, and what jobs printed
state=$(dirname "$0")/state
mkdir -p "$state/queue"
if [ "$(cat "$state/silent" 2>/dev/null)" = "${0##*/}" ]; then
    exec sleep 600
fi
case ${0##*/} in
scontrol) echo "MaxArraySize            = 1001" ;;
squeue) cat "$state"/queue/* 2>/dev/null || true ;;
scancel)
    echo "$*" >>"$state/cancelled"
    for task; do
        file=$state/queue/${task%%_*}
        sed -i "/^$task|/d" "$file"
        [ -s "$file" ] || rm -f "$file"
    done
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
        own=$state/queue/$number
        echo "$number|PENDING|Dependency" >"$own"
        (
            while cat "$state"/queue/* 2>/dev/null | grep -q _; do sleep 0.1; done
            sleep 1
            # Unless it was cancelled.
            [ -e "$own" ] && SLURM_JOB_ID=$number sh "$script"
            rm -f "$own"
        ) >>"$state/log" 2>&1 &
    else
        for run in $(echo "$array" | tr , ' '); do
            for task in $(seq "${run%-*}" "${run#*-}"); do
                if [ -e "$state/held" ] && [ "$number" = 1 ]; then
                    echo "${number}_$task|PENDING|launch failed requeued held" >>"$state/queue/$number"
                elif ! [ -e "$state/lost" ]; then
                    SLURM_JOB_ID=$number SLURM_ARRAY_TASK_ID=$task bash "$script" "$offset"
                fi
            done
        done >>"$state/log" 2>&1
    fi
    echo "$number"
    ;;
esac
