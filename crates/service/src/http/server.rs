//! Connections under deadlines, and the end of service: what is under way is finished.

use super::router;
use crate::app::App;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::GracefulShutdown;
use hyper_util::service::TowerToHyperService;
use std::io;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::Semaphore;

/// Time in which a client must take what was sent [ms].
const SEND_MS: u32 = 60_000;

/// Serves until a signal ends it; a second one ends it at once.
///
/// # Errors
///
/// [`io::Error`] if signals cannot be heard.
pub async fn serve(app: App, listener: TcpListener) -> io::Result<()> {
    let mut terminate = signal(SignalKind::terminate())?;
    let mut interrupt = signal(SignalKind::interrupt())?;
    let places = Arc::new(Semaphore::new(app.config.connections));
    let graceful = GracefulShutdown::new();
    let router = router(app.clone());
    let mut builder = http1::Builder::new();
    builder
        .timer(TokioTimer::new())
        .header_read_timeout(app.config.header_time)
        .max_buf_size(64 << 10);
    loop {
        let place = tokio::select! {
            place = Arc::clone(&places).acquire_owned() => place,
            _ = terminate.recv() => break,
            _ = interrupt.recv() => break,
        };
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            _ = terminate.recv() => break,
            _ = interrupt.recv() => break,
        };
        let stream = match accepted {
            Ok((stream, _)) => stream,
            Err(error) => {
                // Too many open files, mostly; the next moment may be better.
                tracing::warn!(%error, "a connection could not be taken");
                tokio::time::sleep(Duration::from_millis(50)).await;
                continue;
            }
        };
        bound(&stream);
        let service =
            TowerToHyperService::new(router.clone().into_service::<hyper::body::Incoming>());
        let connection = builder.serve_connection(TokioIo::new(stream), service);
        let connection = graceful.watch(connection);
        tokio::spawn(async move {
            if let Err(error) = connection.await {
                tracing::debug!(%error, "a connection ended");
            }
            drop(place);
        });
    }
    drop(listener);
    app.ends.store(true, Ordering::Relaxed);
    tracing::info!("ending: what is under way is finished");
    let drained = async {
        graceful.shutdown().await;
        let crew = app.clone();
        let _ = tokio::task::spawn_blocking(move || crew.crew.end()).await;
    };
    tokio::select! {
        () = drained => tracing::info!("ended"),
        () = tokio::time::sleep(app.config.drain) => tracing::warn!("ended before all was done"),
        _ = terminate.recv() => tracing::warn!("ended at once"),
        _ = interrupt.recv() => tracing::warn!("ended at once"),
    }
    Ok(())
}

/// Does not wait for ever for a client that takes nothing.
fn bound(stream: &TcpStream) {
    let _ = stream.set_nodelay(true);
    let _ = rustix::net::sockopt::set_tcp_user_timeout(stream, SEND_MS);
}
