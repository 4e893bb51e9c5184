//! Connections under deadlines, and the end of the service, which finishes requests in progress.

use super::caller::Peer;
use super::listener::{Listener, NO_ADDRESS};
use super::paced::Paced;
use super::places::{Places, Spare};
use super::router;
use crate::app::App;
use axum::http::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::{Service as _, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::GracefulShutdown;
use hyper_util::service::TowerToHyperService;
use std::io;
use std::sync::atomic::Ordering;
use std::time::Duration;
use tokio::signal::unix::{Signal, SignalKind, signal};

/// Longest time of a connection without a place.
const SPARE_TIME: Duration = Duration::from_secs(5);

/// The signals that end the service. They are caught from the making of this on, so it is made before
/// the service says where it listens: whoever read that may end it.
#[derive(Debug)]
pub struct EndingSignals {
    terminate: Signal,
    interrupt: Signal,
}

impl EndingSignals {
    /// Catches them.
    ///
    /// # Errors
    ///
    /// [`io::Error`] if signals cannot be received.
    pub fn catch() -> io::Result<Self> {
        Ok(Self {
            terminate: signal(SignalKind::terminate())?,
            interrupt: signal(SignalKind::interrupt())?,
        })
    }

    async fn come(&mut self) {
        tokio::select! {
            _ = self.terminate.recv() => (),
            _ = self.interrupt.recv() => (),
        }
    }
}

/// Serves until a signal ends it; a second one ends it at once.
pub async fn serve(app: App, listener: Listener, mut signals: EndingSignals) {
    let (places, mut spare) = (Places::default(), Spare::default());
    let graceful = GracefulShutdown::new();
    let router = router(app.clone());
    let mut builder = http1::Builder::new();
    builder
        .timer(TokioTimer::new())
        .header_read_timeout(app.config.header_time)
        .max_buf_size(16 << 10);
    let mut builder_of_spare = builder.clone();
    builder_of_spare.keep_alive(false);
    loop {
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            () = signals.come() => break,
        };
        let (stream, peer) = match accepted {
            Ok(accepted) => accepted,
            Err(error) => {
                // The usual cause is too many open files, which may pass.
                tracing::warn!(%error, "a connection could not be taken");
                tokio::time::sleep(Duration::from_millis(50)).await;
                continue;
            }
        };
        let is_proxy = peer.is_none_or(|address| app.config.proxies.contains(&address));
        let own_most = if is_proxy {
            app.config.connections
        } else {
            app.config.address_connections
        };
        let address = peer.unwrap_or(NO_ADDRESS);
        let place = places.take(address, app.config.connections, own_most);
        let peer = Peer {
            address,
            is_proxy,
            is_spare: place.is_none(),
        };
        let service = TowerToHyperService::new(router.clone().into_service::<Incoming>());
        let service = service_fn(move |mut request: Request<Incoming>| {
            request.extensions_mut().insert(peer);
            service.call(request)
        });
        let stream = TokioIo::new(Paced::new(stream));
        let Some(place) = place else {
            let connection = builder_of_spare.serve_connection(stream, service);
            let connection = tokio::spawn(tokio::time::timeout(SPARE_TIME, connection));
            spare.push(connection.abort_handle());
            continue;
        };
        let connection = graceful.watch(builder.serve_connection(stream, service));
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
        () = signals.come() => tracing::warn!("ended at once"),
    }
}
