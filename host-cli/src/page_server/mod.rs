//! Serves a page to the browser on this machine, and answers its questions.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `access.rs` | who may ask: hosts, origins, the key in the link |
//! | `answer.rs` | questions read, answers written |
//!
//! What is asked is left to the pages: [`crate::model_page`], [`crate::robot_page`].

mod access;
mod answer;

use std::net::{IpAddr, SocketAddr, TcpListener};
use std::time::Duration;

use axum::Router;
use axum::extract::{DefaultBodyLimit, Request, State};
use axum::http::{HeaderName, HeaderValue, StatusCode, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::Response;
use axum::routing::get;
use futures_lite::future;

pub use access::{Access, Refused};
pub use answer::{answered, question, told};

use crate::calibration_page::drawing::COLOURS;
use crate::error::{Error, Result};
use crate::interrupt;

/// The largest question \[bytes\].
const QUESTION_MAX: usize = 64 * 1024;

/// Nothing from elsewhere, nothing inline, in no frame.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data:; \
    base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// A page: its text, its style sheet without the colours, its scripts by name in the order in which they are read.
#[derive(Clone, Copy, Debug)]
pub struct Page {
    /// HTML.
    pub html: &'static str,
    /// CSS.
    pub css: &'static str,
    /// JavaScript.
    pub scripts: &'static [(&'static str, &'static str)],
}

impl Page {
    /// The style sheet, in the colours of all pages.
    pub fn style(&self) -> String {
        format!("{COLOURS}\n{}", self.css)
    }

    fn has(&self, name: &str) -> bool {
        name == "page.css" || self.scripts.iter().any(|(script, _)| *script == name)
    }

    fn router<S: Clone + Send + Sync + 'static>(self) -> Router<S> {
        const HTML: &str = "text/html; charset=utf-8";
        const CSS: &str = "text/css; charset=utf-8";
        const SCRIPT: &str = "text/javascript; charset=utf-8";
        let mut router = Router::new()
            .route("/", get(move || async move { answer::file(self.html, HTML) }))
            .route("/page.css", get(move || async move { answer::file(self.style(), CSS) }));
        for (name, text) in self.scripts {
            let script = get(move || async move { answer::file(*text, SCRIPT) });
            router = router.route(&format!("/{name}"), script);
        }
        router
    }
}

/// An address that a page will be served at.
pub struct Server {
    listener: TcpListener,
    access: Access,
    address: SocketAddr,
}

impl Server {
    /// Takes the address.
    pub fn bind(address: SocketAddr) -> std::io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        let address = listener.local_addr()?;
        let access = Access::at(address).map_err(std::io::Error::other)?;
        Ok(Self { listener, access, address })
    }

    /// Of its address.
    pub fn ip(&self) -> IpAddr {
        self.address.ip()
    }

    /// The link to the page.
    pub fn link(&self) -> String {
        format!("http://{}/{}", self.address, self.access.query())
    }

    /// Serves a page and its answers until Ctrl-C.
    pub fn run<S: Clone + Send + Sync + 'static>(
        self,
        page: Page,
        answers: Router<S>,
        state: S,
    ) -> Result<()> {
        let failed = |error: std::io::Error| Error::new(format_args!("the page ended: {error}"));
        interrupt::listen();
        self.listener.set_nonblocking(true).map_err(failed)?;
        let router = page
            .router()
            .merge(answers)
            .fallback(|| async { told(StatusCode::NOT_FOUND, "there is no such page") })
            .method_not_allowed_fallback(|| async {
                told(StatusCode::METHOD_NOT_ALLOWED, "this is asked in another way")
            })
            .layer(DefaultBodyLimit::max(QUESTION_MAX))
            .layer(from_fn_with_state((self.access, page), guard))
            .with_state(state);
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(2)
            // So many questions are computed at once; others wait.
            .max_blocking_threads(8)
            .enable_all()
            .build()
            .map_err(failed)?;
        let served = runtime.block_on(async {
            let listener = tokio::net::TcpListener::from_std(self.listener).map_err(failed)?;
            let serve = async { axum::serve(listener, router).await.map_err(failed) };
            future::or(serve, asked_to_end()).await
        });
        // What is still being computed is for nobody, and a page that listens to telemetry never ends.
        runtime.shutdown_background();
        served
    }
}

async fn asked_to_end() -> Result<()> {
    const LOOKED_EVERY: Duration = Duration::from_millis(20);
    while !interrupt::requested() {
        tokio::time::sleep(LOOKED_EVERY).await;
    }
    Ok(())
}

/// Refuses strangers, and tells the browser what the page may do.
async fn guard(
    State((access, page)): State<(Access, Page)>,
    request: Request,
    next: Next,
) -> Response {
    let mut response = match checked(&access, page, &request) {
        Ok(()) => next.run(request).await,
        Err(refused) => told(StatusCode::FORBIDDEN, refused.words()),
    };
    if is_unworded(&response) {
        let status = response.status();
        let problem = match status {
            StatusCode::PAYLOAD_TOO_LARGE => {
                format!("a question has at most {} KiB", QUESTION_MAX / 1024)
            }
            _ => status.canonical_reason().unwrap_or("this cannot be answered").to_lowercase(),
        };
        response = told(status, &problem);
    }
    let headers = response.headers_mut();
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
        (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    response
}

/// Whether a refusal is the server's own, and so not in JSON as all others are.
fn is_unworded(response: &Response) -> bool {
    let status = response.status();
    let is_refusal = status.is_client_error() || status.is_server_error();
    let kind = response.headers().get(header::CONTENT_TYPE).map(HeaderValue::as_bytes);
    is_refusal && kind != Some(b"application/json")
}

/// Whether a request may be answered.
fn checked(access: &Access, page: Page, request: &Request) -> std::result::Result<(), Refused> {
    let text = |name: HeaderName| {
        request.headers().get(name).map(|value| value.to_str().unwrap_or_default())
    };
    let mut in_link = request.uri().query().unwrap_or_default().split('&');
    let in_link = in_link.find_map(|part| part.strip_prefix("key="));
    let key = text(HeaderName::from_static("x-beeline-key")).or(in_link);
    // What is the same for everybody has nothing to hide: the page asks for it without the key.
    let is_asset = page.has(request.uri().path().trim_start_matches('/'));
    match access.check(text(header::HOST), text(header::ORIGIN), key) {
        Err(Refused::Key) if is_asset => Ok(()),
        verdict => verdict,
    }
}
