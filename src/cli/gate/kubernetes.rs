//! Shares as an Indexed Job of Kubernetes: printed, for others to fill in and to apply.

use latchgate_report::escape::shell as quoted;
use serde_json::{Value, json};

/// Most indexes that may fail: what the API takes of a job of any size.
const FAILED_MAX: u32 = 10_000;

/// Returns the manifest of a job whose every index judges one share. JSON is YAML, too.
///
/// `command` is the command line of a share up to its number, as it is called in the container.
pub(super) fn manifest(gate: &str, shares: u32, command: &[String]) -> Value {
    let words = command.iter().map(|word| quoted(word));
    let command = words.collect::<Vec<_>>().join(" ");
    let script =
        format!("exec {command} --threads 1 --part \"$((JOB_COMPLETION_INDEX + 1))/{shares}\"");
    let name: String = format!("latchgate-{gate}")
        .to_lowercase()
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '-' })
        .take(52)
        .collect();
    let container = json!({
        "name": "share",
        "image": "latchgate:latest",
        "workingDir": "/sweep",
        "command": ["/bin/sh", "-c", script],
        "resources": {"requests": {"cpu": "1", "memory": "256Mi"}, "limits": {"memory": "1Gi"}},
        "volumeMounts": [{"name": "sweep", "mountPath": "/sweep"}],
    });
    // Wrong usage fails every share alike; a node that is drained is no fault of a share.
    let rules = json!([
        {"action": "FailIndex",
         "onExitCodes": {"containerName": "share", "operator": "In", "values": [2]}},
        {"action": "Ignore", "onPodConditions": [{"type": "DisruptionTarget", "status": "True"}]},
    ]);
    json!({
        "apiVersion": "batch/v1",
        "kind": "Job",
        "metadata": {"name": name.trim_end_matches('-')},
        "spec": {
            "completionMode": "Indexed",
            "completions": shares,
            "parallelism": shares.min(100),
            "backoffLimitPerIndex": 3,
            "maxFailedIndexes": shares.min(FAILED_MAX),
            "podFailurePolicy": {"rules": rules},
            "template": {"spec": {
                "restartPolicy": "Never",
                "terminationGracePeriodSeconds": 30,
                "containers": [container],
                "volumes": [{"name": "sweep",
                             "persistentVolumeClaim": {"claimName": "latchgate-sweep"}}],
            }},
        },
    })
}
