//! The page and its questions over HTTP.
//!
//! | request | answer |
//! | --- | --- |
//! | `GET /`, `/page.css`, `/page.js`, ... | the page |
//! | `GET /api/campaign` | robot, runs as measured, catalogue |
//! | `GET /api/explanation` | what `explain` has found so far |
//! | `POST /api/model` | a model, fitted or at values set by hand, and what it leaves |
//! | `POST /api/equation` | whether an equation of the user's own can be read; added to the effects if asked |
//! | `POST /api/save` | the model is written as `model.toml` |

use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;

use axum::Router;
use axum::body::Bytes;
use axum::extract::{DefaultBodyLimit, Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use super::access::{Access, Refused};
use super::offline::{PAGE, SCRIPTS, style};
use super::request::ModelRequest;
use super::workbench::Workbench;
use crate::error::{Error, Result};

/// The largest question \[bytes\].
const QUESTION_MAX: usize = 64 * 1024;

/// Nothing from elsewhere, nothing inline, in no frame.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data:; \
    base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// A page that is ready to be served.
pub struct Server {
    listener: TcpListener,
    access: Access,
    address: SocketAddr,
}

/// A question about an equation.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EquationRequest {
    equation: String,
    /// Whether it joins the effects.
    #[serde(default)]
    add: bool,
}

/// An answer, or what is wrong with the question.
type Answered = std::result::Result<Arc<Value>, Value>;

impl Server {
    /// Takes the address.
    pub fn bind(address: SocketAddr) -> std::io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        let address = listener.local_addr()?;
        let access = Access::at(address).map_err(std::io::Error::other)?;
        Ok(Self { listener, access, address })
    }

    /// The link to the page.
    pub fn link(&self) -> String {
        format!("http://{}/{}", self.address, self.access.query())
    }

    /// Serves the page until the program ends.
    pub fn run(self, workbench: Arc<Workbench>) -> Result<()> {
        let failed = |error: std::io::Error| Error::new(format_args!("the page ended: {error}"));
        self.listener.set_nonblocking(true).map_err(failed)?;
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(2)
            .enable_all()
            .build()
            .map_err(failed)?;
        runtime.block_on(async {
            let listener = tokio::net::TcpListener::from_std(self.listener).map_err(failed)?;
            axum::serve(listener, router(workbench, self.access)).await.map_err(failed)
        })
    }
}

fn router(workbench: Arc<Workbench>, access: Access) -> Router {
    let mut router = Router::new()
        .route("/", get(|| async { file(PAGE, "text/html; charset=utf-8") }))
        .route("/page.css", get(|| async { file(style(), "text/css; charset=utf-8") }));
    for (name, text) in SCRIPTS {
        let script = get(move || async move { file(text, "text/javascript; charset=utf-8") });
        router = router.route(&format!("/{name}"), script);
    }
    router
        .route("/api/campaign", get(campaign))
        .route("/api/explanation", get(explanation))
        .route("/api/model", post(model))
        .route("/api/equation", post(equation))
        .route("/api/save", post(save))
        .fallback(|| async { told(StatusCode::NOT_FOUND, "there is no such page") })
        .method_not_allowed_fallback(|| async {
            told(StatusCode::METHOD_NOT_ALLOWED, "this is asked in another way")
        })
        .layer(DefaultBodyLimit::max(QUESTION_MAX))
        .layer(from_fn_with_state(access, guard))
        .with_state(workbench)
}

/// Refuses strangers, and tells the browser what the page may do.
async fn guard(State(access): State<Access>, request: Request, next: Next) -> Response {
    let mut response = match checked(&access, &request) {
        Ok(()) => next.run(request).await,
        Err(refused) => told(StatusCode::FORBIDDEN, refused.words()),
    };
    let headers = response.headers_mut();
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
        (header::HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
        (header::HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    response
}

/// Whether a request may be answered.
fn checked(access: &Access, request: &Request) -> std::result::Result<(), Refused> {
    let text = |name: header::HeaderName| {
        request.headers().get(name).map(|value| value.to_str().unwrap_or_default())
    };
    let mut in_link = request.uri().query().unwrap_or_default().split('&');
    let in_link = in_link.find_map(|part| part.strip_prefix("key="));
    let key = text(header::HeaderName::from_static("x-beeline-key")).or(in_link);
    // What is the same for everybody has nothing to hide: the page asks for it without the key.
    let name = request.uri().path().trim_start_matches('/');
    let is_asset = name == "page.css" || SCRIPTS.iter().any(|(script, _)| *script == name);
    match access.check(text(header::HOST), text(header::ORIGIN), key) {
        Err(Refused::Key) if is_asset => Ok(()),
        verdict => verdict,
    }
}

fn file(text: impl IntoResponse, kind: &'static str) -> Response {
    ([(header::CONTENT_TYPE, kind)], text).into_response()
}

fn told(status: StatusCode, problem: &str) -> Response {
    answered(status, &json!({"error": problem}))
}

fn answered(status: StatusCode, value: &Value) -> Response {
    (status, [(header::CONTENT_TYPE, "application/json")], value.to_string()).into_response()
}

/// Computes an answer beside the server's own threads.
async fn compute(work: impl FnOnce() -> Answered + Send + 'static) -> Response {
    match tokio::task::spawn_blocking(work).await {
        Ok(Ok(value)) => answered(StatusCode::OK, &value),
        Ok(Err(problem)) => answered(StatusCode::UNPROCESSABLE_ENTITY, &problem),
        Err(_) => told(StatusCode::INTERNAL_SERVER_ERROR, "this question ended in a panic"),
    }
}

/// The question in a request: JSON, and declared as such, which no form of another page can do. Otherwise what the
/// asker is told.
fn question<T: DeserializeOwned>(
    headers: &HeaderMap,
    body: &Bytes,
) -> std::result::Result<T, (StatusCode, String)> {
    let kind = headers.get(header::CONTENT_TYPE).map(HeaderValue::as_bytes);
    if kind != Some(b"application/json") {
        return Err((StatusCode::UNSUPPORTED_MEDIA_TYPE, "ask in application/json".to_owned()));
    }
    serde_json::from_slice(body)
        .map_err(|error| (StatusCode::BAD_REQUEST, format!("the question cannot be read: {error}")))
}

fn in_words(outcome: std::result::Result<Value, String>) -> Answered {
    outcome.map(Arc::new).map_err(|problem| json!({"error": problem}))
}

async fn campaign(State(workbench): State<Arc<Workbench>>) -> Response {
    compute(move || Ok(Arc::new(workbench.campaign()))).await
}

async fn explanation(State(workbench): State<Arc<Workbench>>) -> Response {
    answered(StatusCode::OK, &workbench.explanation())
}

async fn model(
    State(workbench): State<Arc<Workbench>>,
    headers: HeaderMap,
    body: Bytes,
) -> Response {
    match question::<ModelRequest>(&headers, &body) {
        Err((status, problem)) => told(status, &problem),
        Ok(request) => {
            let answer = move || workbench.model_answer(&request);
            compute(move || answer().map_err(|problem| json!({"error": problem}))).await
        }
    }
}

async fn equation(
    State(workbench): State<Arc<Workbench>>,
    headers: HeaderMap,
    body: Bytes,
) -> Response {
    match question::<EquationRequest>(&headers, &body) {
        Err((status, problem)) => told(status, &problem),
        Ok(EquationRequest { equation, add }) => {
            let outcome = move || match add {
                true => workbench.add_equation(&equation),
                false => Workbench::check_equation(&equation),
            };
            compute(move || outcome().map(Arc::new)).await
        }
    }
}

async fn save(
    State(workbench): State<Arc<Workbench>>,
    headers: HeaderMap,
    body: Bytes,
) -> Response {
    match question::<ModelRequest>(&headers, &body) {
        Err((status, problem)) => told(status, &problem),
        Ok(request) => compute(move || in_words(workbench.save(&request))).await,
    }
}
