#!/usr/bin/env bash
# Asks a service what schemathesis makes up from its own description: twice, at random and about what is
# stored. Ends with 1 where an answer is no JSON as described, or says that the service failed.
#
#     pip install schemathesis==4.32.5
#     crates/service/tests/contract.sh [PROGRAM] [EXAMPLES]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../../.."
program=$(realpath "${1:-target/debug/latchgate-serve}") examples=${2:-350}
place=$(mktemp -d)
"$program" --listen 127.0.0.1:0 --data "$place/data" --set rate_per_s=100000 --set rate_burst=100000 \
    --set log=warn --set own_mib=64 > "$place/told" 2> "$place/log" &
service=$!
trap 'kill "$service"; rm -rf "$place"' EXIT
until grep -q http "$place/told"; do sleep 0.1; done
base=$(sed 's/.*\(http:[^,]*\)\/,.*/\1/' "$place/told")
read_id() { python3 -c "import json, sys; print(json.load(sys.stdin)['$1'])"; }
recording=$(curl -sS --data-binary @signals/burst.csv "$base/v1/recordings?name=burst.csv" | read_id id)
report=$(curl -sS -H 'content-type: application/json' "$base/v1/verdicts?wait=60" \
    -d "{\"recording\": \"$recording\", \"request\": {\"members\": 0}}" | read_id report_id)
gate=$(printf '[[recordings]]\nfiles = "burst.csv"\nmembers = 0\n[[designs]]\nname = "paper"\n' |
    curl -sS --data-binary @- "$base/v1/gates" | read_id id)
curl -sS -H 'content-type: application/json' "$base/v1/designs" -d '{"name": "latch"}' > "$place/design"
cat > "$place/known.toml" <<KNOWN
[parameters]
"path.report_id" = "$report"
"path.file" = ["report.html", "series.csv", "event.svg", "summary.json", "junit.xml", "summary.md"]
"path.name" = ["latch", "latch@1"]
[[operations]]
include-path = "/v1/recordings/{id}"
parameters = { id = "$recording" }
[[operations]]
include-path-regex = "/v1/gates/.*"
parameters = { id = "$gate" }
KNOWN
: > "$place/none.toml"
cd "$place"
for known in none known; do
    schemathesis --config-file "$place/$known.toml" run "$base/openapi.json" --phases coverage,fuzzing \
        --max-examples "$examples" --request-timeout 60 --seed 17 --no-color --checks \
        not_a_server_error,status_code_conformance,content_type_conformance,response_schema_conformance
done
