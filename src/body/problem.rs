//! Every refusal of the HTTP side, as an RFC 9457 problem document.

use http::StatusCode;
use serde::Serialize;
use serde_json::Value;

use crate::scene::SceneError;

/// A refusal. `kind` is for programs and never changes its meaning; `detail` is for people.
#[derive(Clone, Debug)]
pub struct Problem(Box<Content>);

#[derive(Clone, Debug)]
struct Content {
    status: StatusCode,
    kind: &'static str,
    title: &'static str,
    detail: String,
    field: Option<String>,
    value: Option<Value>,
    bound: Option<Value>,
    retry_after_s: Option<u32>,
}

/// The document as it is written.
#[derive(Serialize)]
struct Document<'a> {
    r#type: String,
    title: &'a str,
    status: u16,
    detail: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    field: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    value: Option<&'a Value>,
    #[serde(skip_serializing_if = "Option::is_none")]
    bound: Option<&'a Value>,
}

impl Problem {
    /// A refusal without a field.
    pub fn new(status: StatusCode, kind: &'static str, title: &'static str, detail: impl Into<String>) -> Self {
        let detail = detail.into();
        let content =
            Content { status, kind, title, detail, field: None, value: None, bound: None, retry_after_s: None };
        Self(Box::new(content))
    }

    /// No such path or scene.
    pub fn not_found(detail: impl Into<String>) -> Self {
        Self::new(StatusCode::NOT_FOUND, "not-found", "Not found", detail)
    }

    /// Something of ours failed; the log of the server says what.
    pub fn internal(detail: impl Into<String>) -> Self {
        Self::new(StatusCode::INTERNAL_SERVER_ERROR, "internal", "The server failed", detail)
    }

    /// Not what the sea is now.
    pub fn conflict(kind: &'static str, detail: impl Into<String>) -> Self {
        Self::new(StatusCode::CONFLICT, kind, "Not possible as the sea is", detail)
    }

    /// A field that holds what it must not.
    pub fn value(field: impl Into<String>, value: Value, bound: impl Into<Value>) -> Self {
        let (field, bound) = (field.into(), bound.into());
        let detail = format!("{field} is {value}, must be {}", bound.as_str().map_or(bound.to_string(), str::to_owned));
        Self::new(StatusCode::UNPROCESSABLE_ENTITY, "invalid-value", "A value is out of bounds", detail)
            .at(field)
            .found(value)
            .allowed(bound)
    }

    /// Names the field at fault.
    pub fn at(mut self, field: impl Into<String>) -> Self {
        self.0.field = Some(field.into());
        self
    }

    /// Says what was found.
    pub fn found(mut self, value: impl Into<Value>) -> Self {
        self.0.value = Some(value.into());
        self
    }

    /// Says what is allowed.
    pub fn allowed(mut self, bound: impl Into<Value>) -> Self {
        self.0.bound = Some(bound.into());
        self
    }

    /// How it is told over HTTP.
    pub fn status(&self) -> StatusCode {
        self.0.status
    }

    /// When to try again, seconds from now, where that may help.
    pub fn retry_after_s(&self) -> Option<u32> {
        self.0.retry_after_s
    }

    /// What is wrong, for people.
    pub fn detail(&self) -> &str {
        &self.0.detail
    }

    /// The document as it is sent.
    pub fn document(&self) -> String {
        let problem = &self.0;
        let document = Document {
            r#type: format!("urn:swellcast:problem:{}", problem.kind),
            title: problem.title,
            status: problem.status.as_u16(),
            detail: &problem.detail,
            field: problem.field.as_deref(),
            value: problem.value.as_ref(),
            bound: problem.bound.as_ref(),
        };
        serde_json::to_string(&document).unwrap_or_default()
    }

    /// Says when to try again.
    pub fn retry_after(mut self, seconds: u32) -> Self {
        self.0.retry_after_s = Some(seconds);
        self
    }
}

impl From<SceneError> for Problem {
    fn from(error: SceneError) -> Self {
        let detail = error.to_string();
        match error {
            // The one refusal that no other value of the request would lift.
            SceneError::Bound { field, .. } if field == "wind" => Self::conflict("not-wind-driven", detail).at(field),
            SceneError::Bound { field, value, bound } => {
                let value = serde_json::from_str(&value).unwrap_or(Value::String(value));
                Self::value(field, value, bound)
            }
            SceneError::Form(_) | SceneError::Measured(_) => {
                Self::new(StatusCode::UNPROCESSABLE_ENTITY, "invalid-value", "A value is out of bounds", detail)
            }
        }
    }
}
