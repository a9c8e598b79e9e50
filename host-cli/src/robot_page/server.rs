//! The page's telemetry and wishes over HTTP.
//!
//! | request | answer |
//! | --- | --- |
//! | `GET /api/telemetry` | a stream of events: the robot's condition, and each frame of its telemetry once |
//! | `POST /api/hold` | a button is held: begins a motion, or gives it another lease |
//! | `POST /api/stop`, `/api/cut`, `/api/clear` | brakes; zero duty at once; clears the fault |

use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::body::Bytes;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode};
use axum::response::sse::{Event, Sse};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use futures_lite::stream::unfold;
use serde_json::{Value, json};

use super::robot::{Hold, Robot, Wish};
use crate::error::Result;
use crate::page_server::{Page, Server, answered, question, told};

/// News are sent this often: thirty times a second.
const NEWS_EVERY: Duration = Duration::from_millis(33);

const PAGE: Page = Page {
    html: include_str!("assets/robot.html"),
    css: include_str!("assets/robot.css"),
    scripts: &[
        ("chart.js", include_str!("assets/chart.js")),
        ("drive.js", include_str!("assets/drive.js")),
        ("robot.js", include_str!("assets/robot.js")),
    ],
};

/// Serves the page until Ctrl-C.
pub fn serve(server: Server, robot: Arc<Robot>) -> Result<()> {
    let answers = Router::new()
        .route("/api/telemetry", get(telemetry))
        .route("/api/hold", post(hold))
        .route("/api/stop", post(|state, headers, body| wish(state, headers, body, Wish::Stop)))
        .route("/api/cut", post(|state, headers, body| wish(state, headers, body, Wish::CutMotors)))
        .route("/api/clear", post(|state, headers, body| wish(state, headers, body, Wish::Clear)));
    server.run(PAGE, answers, robot)
}

async fn telemetry(State(robot): State<Arc<Robot>>) -> Response {
    let news = unfold((robot, 0), |(robot, seen)| async move {
        tokio::time::sleep(NEWS_EVERY).await;
        let (news, seen) = robot.news(seen);
        Some((Ok::<_, Infallible>(Event::default().data(news.to_string())), (robot, seen)))
    });
    Sse::new(news).into_response()
}

async fn hold(State(robot): State<Arc<Robot>>, headers: HeaderMap, body: Bytes) -> Response {
    match question::<Hold>(&headers, &body) {
        Err((status, problem)) => told(status, &problem),
        Ok(hold) => {
            robot.wish(Wish::Hold(hold));
            answered(StatusCode::OK, &json!({}))
        }
    }
}

async fn wish(
    State(robot): State<Arc<Robot>>,
    headers: HeaderMap,
    body: Bytes,
    wish: Wish,
) -> Response {
    match question::<Value>(&headers, &body) {
        Err((status, problem)) => told(status, &problem),
        Ok(_) => {
            robot.wish(wish);
            answered(StatusCode::OK, &json!({}))
        }
    }
}
