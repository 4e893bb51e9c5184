//! State of the gates on a cluster, as this process last read it.

use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// What the queue has of a gate.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct EngineTasks {
    /// Tasks that run.
    #[serde(default)]
    pub running: u64,
    /// Tasks that wait.
    #[serde(default)]
    pub waiting: u64,
    /// Tasks that will never run.
    #[serde(default)]
    pub stuck: u64,
    /// Whether the job that collects runs or waits.
    #[serde(default)]
    pub collecting: bool,
    /// Why the queue could not be asked, where it could not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
}

/// State of a gate on the cluster since this process began.
#[derive(Debug, Clone, Default)]
pub(crate) struct Look {
    pub(crate) decided: u64,
    pub(crate) tasks: Option<EngineTasks>,
    pub(crate) gone: u32,
    pub(crate) unanswered: u32,
    pub(crate) resubmits: u32,
    pub(crate) next: Option<Instant>,
}

/// States of the gates on a cluster.
#[derive(Debug, Default)]
pub struct Engine(Mutex<HashMap<String, Look>>);

impl Engine {
    /// Locks the states, by gate.
    pub(crate) fn looks(&self) -> MutexGuard<'_, HashMap<String, Look>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the number of decided pairs of a gate, and its tasks in the queue.
    pub fn seen(&self, id: &str) -> (u64, Option<EngineTasks>) {
        let looks = self.looks();
        let look = looks.get(id);
        look.map_or((0, None), |look| (look.decided, look.tasks.clone()))
    }
}
