//! The page's telemetry, wishes and procedures over HTTP.
//!
//! | request | answer |
//! | --- | --- |
//! | `GET /api/telemetry` | a stream of events: the robot's condition, each frame of its telemetry once, the procedure when it changes |
//! | `POST /api/hold` | a button is held: begins a motion, or gives it another lease |
//! | `POST /api/stop`, `/api/cut`, `/api/clear` | brakes; zero duty at once; clears the fault |
//! | `POST /api/procedure/begin`, `/stop` | begins a procedure; ends it in good order |
//! | `POST /api/procedure/hold` | a sign of life: its motions go on |
//! | `POST /api/procedure/answer` | the answer to a question |
//! | `POST /api/procedure/explain` | serves the page on which the campaign's effects are switched |
//! | `GET /api/drawing` | the drawing of the last calibration |

use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::body::Bytes;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::sse::{Event, Sse};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use futures_lite::stream::unfold;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use super::asked::Asked;
use super::procedure::Procedures;
use super::robot::{Heard, HeldMotion, Hold, Robot, Wish};
use crate::error::Result;
use crate::page_server::{Page, Server, answered, question, told};

/// News are sent this often: thirty times a second.
const NEWS_EVERY: Duration = Duration::from_millis(33);

/// An arc of a smaller radius is a spin \[m\].
const RADIUS_M_MIN: f64 = 1e-3;

const PAGE: Page = Page {
    html: include_str!("assets/robot.html"),
    css: concat!(include_str!("assets/robot.css"), include_str!("assets/procedure.css")),
    scripts: &[
        ("telemetry.js", include_str!("assets/telemetry.js")),
        ("chart.js", include_str!("assets/chart.js")),
        ("timeline.js", include_str!("assets/timeline.js")),
        ("paths.js", include_str!("assets/paths.js")),
        ("floor.js", include_str!("assets/floor.js")),
        ("drive.js", include_str!("assets/drive.js")),
        ("tabs.js", include_str!("assets/tabs.js")),
        ("controls.js", include_str!("assets/controls.js")),
        ("robot.js", include_str!("assets/robot.js")),
        ("picture.js", include_str!("assets/picture.js")),
        ("campaign_floor.js", include_str!("assets/campaign_floor.js")),
        ("procedure_view.js", include_str!("assets/procedure_view.js")),
        ("question_view.js", include_str!("assets/question_view.js")),
        ("procedure.js", include_str!("assets/procedure.js")),
    ],
};

/// What the page is about.
#[derive(Clone)]
pub struct RobotPage {
    /// The robot.
    pub robot: Arc<Robot>,
    /// What the page guides through.
    pub procedures: Arc<Procedures>,
    /// Whether this program simulates the robot, with a camera above it.
    pub simulated: bool,
}

/// What is to be begun, by which page.
#[derive(Deserialize)]
struct Begin {
    page: u64,
    #[serde(flatten)]
    asked: Asked,
}

/// A sign of life of a page.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Beat {
    page: u64,
    /// Whether it holds the procedure from now on, in the place of another.
    #[serde(default)]
    take: bool,
    /// `now_ms` of the news that the page has heard last.
    heard_ms: u64,
}

/// The answer to a procedure's question.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct AnswerTo {
    number: u32,
    text: String,
}

/// What is wrong with a question of the page.
type Told = (StatusCode, String);

/// Serves the page until Ctrl-C.
pub fn serve(server: Server, page: RobotPage) -> Result<()> {
    let answers = Router::new()
        .route("/api/telemetry", get(telemetry))
        .route("/api/drawing", get(drawing))
        .route("/api/hold", post(|state, headers, body| asked(state, headers, body, hold)))
        .route("/api/stop", post(|state, headers, body| wish(state, headers, body, Wish::Stop)))
        .route("/api/cut", post(|state, headers, body| wish(state, headers, body, Wish::CutMotors)))
        .route("/api/clear", post(|state, headers, body| wish(state, headers, body, Wish::Clear)))
        .route(
            "/api/procedure/begin",
            post(|state, headers, body| asked(state, headers, body, begin)),
        )
        .route(
            "/api/procedure/hold",
            post(|state, headers, body| asked(state, headers, body, beat)),
        )
        .route(
            "/api/procedure/answer",
            post(|state, headers, body| asked(state, headers, body, answer)),
        )
        .route(
            "/api/procedure/stop",
            post(|state, headers, body| {
                asked(state, headers, body, |page: &RobotPage, _: Value| {
                    page.procedures.stop();
                    Ok(json!({}))
                })
            }),
        )
        .route(
            "/api/procedure/explain",
            post(|state, headers, body| asked(state, headers, body, explain)),
        );
    server.run(PAGE, answers, page)
}

async fn telemetry(State(page): State<RobotPage>) -> Response {
    // Whoever begins to listen is told of the procedure, also that there is none.
    let heard = (Heard::default(), (u64::MAX, 0));
    let news = unfold((page, heard), |(page, (heard, seen))| async move {
        tokio::time::sleep(NEWS_EVERY).await;
        let (mut news, heard) = page.robot.news(heard);
        let (procedure, seen) = page.procedures.news(seen);
        if let Some(procedure) = procedure {
            news["procedure"] = procedure;
        }
        let condition = &mut news["condition"];
        if condition.is_object() {
            let drives = page.procedures.running().is_some();
            condition["procedure_drives"] = json!(drives);
            condition["simulated"] = json!(page.simulated);
            if drives {
                // It is no other program's doing.
                condition["driven_by_another"] = json!(false);
            }
        }
        let event = Event::default().data(news.to_string());
        Some((Ok::<_, Infallible>(event), (page, (heard, seen))))
    });
    Sse::new(news).into_response()
}

/// Answers a question of the page.
async fn asked<T: DeserializeOwned>(
    State(page): State<RobotPage>,
    headers: HeaderMap,
    body: Bytes,
    answer: impl FnOnce(&RobotPage, T) -> std::result::Result<Value, Told>,
) -> Response {
    match question::<T>(&headers, &body).and_then(|question| answer(&page, question)) {
        Ok(value) => answered(StatusCode::OK, &value),
        Err((status, problem)) => told(status, &problem),
    }
}

fn hold(page: &RobotPage, hold: Hold) -> std::result::Result<Value, Told> {
    if let HeldMotion::Arc { radius_m, .. } = hold.motion
        && (radius_m.is_nan() || radius_m < RADIUS_M_MIN)
    {
        let problem = "give the arc a radius of a millimetre at least: a spin has none".to_owned();
        return Err((StatusCode::BAD_REQUEST, problem));
    }
    if page.procedures.running().is_some() {
        let problem = "a procedure drives the robot: stop it first".to_owned();
        return Err((StatusCode::CONFLICT, problem));
    }
    page.robot.wish(Wish::Hold(hold));
    Ok(json!({}))
}

fn begin(page: &RobotPage, begin: Begin) -> std::result::Result<Value, Told> {
    if page.robot.moves() {
        let problem = "the robot moves: stop it first".to_owned();
        return Err((StatusCode::CONFLICT, problem));
    }
    let begun = page.procedures.begin(begin.asked, begin.page);
    begun.map(|()| json!({})).map_err(|problem| (StatusCode::CONFLICT, problem))
}

fn beat(page: &RobotPage, beat: Beat) -> std::result::Result<Value, Told> {
    // A message that has waited on its way says nothing of now.
    let is_fresh = page.robot.is_fresh(beat.heard_ms);
    if let Some(procedure) = page.procedures.running().filter(|_| is_fresh) {
        procedure.beat(beat.page, beat.take);
    }
    Ok(json!({}))
}

fn answer(page: &RobotPage, answer: AnswerTo) -> std::result::Result<Value, Told> {
    let AnswerTo { number, text } = answer;
    match page.procedures.running().filter(|procedure| procedure.answer(number, &text)) {
        Some(_) => Ok(json!({})),
        None => Err((StatusCode::CONFLICT, "this is no longer asked".to_owned())),
    }
}

fn explain(page: &RobotPage, _: Value) -> std::result::Result<Value, Told> {
    let link = page.procedures.serve_model();
    link.map(|link| json!({"link": link})).map_err(|problem| (StatusCode::CONFLICT, problem))
}

async fn wish(
    State(page): State<RobotPage>,
    headers: HeaderMap,
    body: Bytes,
    wish: Wish,
) -> Response {
    let answer = |page: &RobotPage, _: Value| {
        page.robot.wish(wish);
        if matches!(wish, Wish::Stop | Wish::CutMotors) {
            page.procedures.stop();
        }
        Ok(json!({}))
    };
    asked(State(page), headers, body, answer).await
}

async fn drawing(State(page): State<RobotPage>) -> Response {
    match page.procedures.drawing().map(std::fs::read) {
        Some(Ok(svg)) => ([(header::CONTENT_TYPE, "image/svg+xml")], svg).into_response(),
        Some(Err(error)) => told(StatusCode::NOT_FOUND, &error.to_string()),
        None => told(StatusCode::NOT_FOUND, "there is no drawing"),
    }
}
