//! Questions of a page read, and answers written.

use axum::body::Bytes;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

/// A part of the page.
pub(super) fn file(text: impl IntoResponse, kind: &'static str) -> Response {
    ([(header::CONTENT_TYPE, kind)], text).into_response()
}

/// What is wrong with a question.
pub fn told(status: StatusCode, problem: &str) -> Response {
    answered(status, &json!({"error": problem}))
}

/// An answer in JSON.
pub fn answered(status: StatusCode, value: &Value) -> Response {
    (status, [(header::CONTENT_TYPE, "application/json")], value.to_string()).into_response()
}

/// The question in a request: JSON, and declared as such, which no form of another page can do. Otherwise what the
/// asker is told.
pub fn question<T: DeserializeOwned>(
    headers: &HeaderMap,
    body: &Bytes,
) -> Result<T, (StatusCode, String)> {
    let kind = headers.get(header::CONTENT_TYPE).map(HeaderValue::as_bytes);
    if kind != Some(b"application/json") {
        return Err((StatusCode::UNSUPPORTED_MEDIA_TYPE, "ask in application/json".to_owned()));
    }
    serde_json::from_slice(body)
        .map_err(|error| (StatusCode::BAD_REQUEST, format!("the question cannot be read: {error}")))
}
