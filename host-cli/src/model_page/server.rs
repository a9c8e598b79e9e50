//! The page's questions over HTTP.
//!
//! | request | answer |
//! | --- | --- |
//! | `GET /api/campaign` | robot, runs as measured, catalogue |
//! | `GET /api/explanation` | what `explain` has found so far |
//! | `POST /api/model` | a model, fitted or at values set by hand, and what it leaves |
//! | `POST /api/equation` | whether an equation of the user's own can be read; added to the effects if asked |
//! | `POST /api/save` | the model is written as `model.toml` |

use std::sync::Arc;

use axum::Router;
use axum::body::Bytes;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode};
use axum::response::Response;
use axum::routing::{get, post};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use super::offline::PAGE;
use super::request::ModelRequest;
use super::workbench::Workbench;
use crate::error::Result;
use crate::page_server::{Server, answered, question, told};

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

/// Serves the page until Ctrl-C.
pub fn serve(server: Server, workbench: Arc<Workbench>) -> Result<()> {
    let answers = Router::new()
        .route("/api/campaign", get(campaign))
        .route("/api/explanation", get(explanation))
        .route("/api/model", post(model))
        .route("/api/equation", post(equation))
        .route("/api/save", post(save));
    server.run(PAGE, answers, workbench)
}

/// Computes an answer beside the server's own threads.
async fn compute(work: impl FnOnce() -> Answered + Send + 'static) -> Response {
    match tokio::task::spawn_blocking(work).await {
        Ok(Ok(value)) => answered(StatusCode::OK, &value),
        Ok(Err(problem)) => answered(StatusCode::UNPROCESSABLE_ENTITY, &problem),
        Err(_) => told(StatusCode::INTERNAL_SERVER_ERROR, "this question ended in a panic"),
    }
}

fn in_words<T>(outcome: std::result::Result<T, String>) -> std::result::Result<T, Value> {
    outcome.map_err(|problem| json!({"error": problem}))
}

async fn campaign(State(workbench): State<Arc<Workbench>>) -> Response {
    compute(move || Ok(Arc::new(workbench.campaign()))).await
}

async fn explanation(State(workbench): State<Arc<Workbench>>) -> Response {
    answered(StatusCode::OK, &workbench.explanation())
}

/// Reads a question, and computes its answer.
async fn answer<T: DeserializeOwned + Send + 'static>(
    headers: &HeaderMap,
    body: &Bytes,
    work: impl FnOnce(T) -> Answered + Send + 'static,
) -> Response {
    match question(headers, body) {
        Err((status, problem)) => told(status, &problem),
        Ok(question) => compute(move || work(question)).await,
    }
}

async fn model(
    State(workbench): State<Arc<Workbench>>,
    headers: HeaderMap,
    body: Bytes,
) -> Response {
    let work = move |request: ModelRequest| in_words(workbench.model_answer(&request));
    answer(&headers, &body, work).await
}

async fn equation(
    State(workbench): State<Arc<Workbench>>,
    headers: HeaderMap,
    body: Bytes,
) -> Response {
    let work = move |EquationRequest { equation, add }: EquationRequest| {
        let outcome = match add {
            true => workbench.add_equation(&equation),
            false => Workbench::check_equation(&equation),
        };
        outcome.map(Arc::new)
    };
    answer(&headers, &body, work).await
}

async fn save(
    State(workbench): State<Arc<Workbench>>,
    headers: HeaderMap,
    body: Bytes,
) -> Response {
    let work = move |request: ModelRequest| in_words(workbench.save(&request).map(Arc::new));
    answer(&headers, &body, work).await
}
