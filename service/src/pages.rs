//! The pages.
use crate::app::App;
use axum::Router;

/// Returns the routes of the pages.
pub fn routes() -> Router<App> {
    Router::new()
}
