#!/usr/bin/env bash
# Holds connections to a service as strangers do, with slowhttptest (heads, bodies, ranges, reading), then asks it
# as fast as wrk can. Meanwhile its health is asked from the same address, and a list from another one.
# Prints how many of those were answered, and the most memory that the service took without its children.
#
#     apt-get install slowhttptest wrk python3
#     crates/service/tests/slow.sh [PROGRAM]
set -euo pipefail
program=$(realpath "${1:-target/release/latchgate-serve}") port=18420
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
ulimit -n 8192
cat > "$place/probe.py" <<'PROBE'
import http.client, sys, time
counts, slowest, end = {"/healthz": [0, 0], "/v1/limits": [0, 0]}, 0, time.time() + 27
while time.time() < end:
    for path, address in (("/healthz", "127.0.0.1"), ("/v1/limits", "127.0.0.2")):
        began = time.time()
        try:
            connection = http.client.HTTPConnection(sys.argv[1], timeout=3, source_address=(address, 0))
            connection.request("GET", path)
            answered = connection.getresponse().status == 200
        except OSError:
            answered = False
        counts[path][not answered] += 1
        if path == "/healthz":
            slowest = max(slowest, time.time() - began)
    time.sleep(0.05)
told = ", ".join(f"{path} {good} of {good + bad}" for path, (good, bad) in counts.items())
print(f"  {told}, health after {slowest * 1000:.0f} ms at most")
PROBE
try() {
    echo "$*"
    "$program" --listen 127.0.0.1:$port --data "$place/data" --set log=warn \
        --set rate_per_s=1000000 --set rate_burst=1000000 > "$place/said" 2> "$place/log" &
    local service=$!
    until "$program" health --listen 127.0.0.1:$port > /dev/null 2>&1; do sleep 0.1; done
    timeout 60 "$@" > "$place/tool" 2>&1 &
    local tool=$!
    python3 "$place/probe.py" 127.0.0.1:$port
    wait "$tool" || true
    grep -E "Requests/sec" "$place/tool" || true
    grep VmHWM "/proc/$service/status"
    kill "$service" && wait "$service"
    rm -rf "$place/data"
}
slow=(slowhttptest -c 2000 -r 200 -i 5 -l 25)
base=http://127.0.0.1:$port
try "${slow[@]}" -H -u $base/healthz
try "${slow[@]}" -B -s 4000 -t POST -u $base/login
try "${slow[@]}" -R -t HEAD -a 10 -b 3000 -u $base/assets/app.js
try "${slow[@]}" -X -w 10 -y 20 -n 5 -z 32 -k 3 -u $base/openapi.json
try wrk -t 2 -c 100 -d 25 $base/assets/app.js
try wrk -t 2 -c 100 -d 25 $base/v1/verdicts
