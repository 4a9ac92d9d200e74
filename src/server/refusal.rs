//! Problems as responses, and those of the control log as problems.

use axum::response::{IntoResponse, Response};
use http::{HeaderValue, StatusCode, header};

use crate::body::Problem;
use crate::control::StoreError;

impl From<StoreError> for Problem {
    fn from(error: StoreError) -> Self {
        if let StoreError::KeyReused { key } = &error {
            let title = "The key stands for another request";
            return Self::new(StatusCode::UNPROCESSABLE_ENTITY, "key-reused", title, error.to_string())
                .at("Idempotency-Key")
                .found(key.as_str());
        }
        tracing::error!(%error, "control log");
        Self::internal("the control log can't be read or written")
    }
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let kind = [(header::CONTENT_TYPE, "application/problem+json"), (header::CACHE_CONTROL, "no-store")];
        let mut response = (self.status(), kind, self.document()).into_response();
        if let Some(seconds) = self.retry_after_s() {
            response.headers_mut().insert(header::RETRY_AFTER, HeaderValue::from(seconds));
        }
        response
    }
}
