//! The HTTP side: paths, what they answer, and how a change is read.

use std::sync::Arc;

use axum::Router;
use axum::body::Body;
use axum::extract::rejection::PathRejection;
use axum::extract::{Path, RawQuery, State};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, patch, post, put};
use http::{HeaderMap, HeaderName, Method, StatusCode, Uri, header};
use serde_json::{Value, json};
use tokio::task::spawn_blocking;

use super::budget::Budget;
use super::ocean::Ocean;
use super::proposal::{Proposal, told};
use super::read_body::{MAX_BODY, read_body};
use super::{accuracy, hello, metrics, plan, probe, upgrade, viewer};
use crate::body::{ChangeBody, Problem};
use crate::scene::{CascadesFile, SceneFile};
use crate::wire::TICKS_PER_SECOND;

/// Most entries of one page of the log, and how many it has unless asked.
const MAX_PAGE: usize = 1000;
const PAGE: usize = 100;
/// Longest idempotency key.
const MAX_KEY: usize = 128;

type Name = Result<Path<String>, PathRejection>;
type Served = State<Arc<Ocean>>;

/// Every path of the server.
pub fn router(ocean: Arc<Ocean>) -> Router {
    Router::new()
        .route("/v1/scenes", get(scenes))
        .route("/v1/scenes/{name}", get(scene))
        .route("/v1/scenes/{name}/wind", put(wind))
        .route("/v1/scenes/{name}/sea", patch(sea))
        .route("/v1/scenes/{name}/layout", put(layout))
        .route("/v1/scenes/{name}/budget", get(budget).put(set_budget))
        .route("/v1/scenes/{name}/probe", post(water_at))
        .route("/v1/scenes/{name}/log", get(log))
        .route("/v1/scenes/{name}/statistics", get(statistics))
        .route("/v1/scenes/{name}/plan", get(plan))
        .route("/v1/scenes/{name}/accuracy", get(errors))
        .route("/v1/time", get(time))
        .route("/v1/stream", get(upgrade::stream))
        .route("/livez", get(async || text("alive\n")))
        .route("/readyz", get(readyz))
        .route("/metrics", get(page))
        .fallback(static_file)
        .method_not_allowed_fallback(wrong_method)
        .with_state(ocean)
}

fn answer(status: StatusCode, body: &Value) -> Response {
    written(status, body.to_string())
}

fn written(status: StatusCode, json: String) -> Response {
    let kind = [(header::CONTENT_TYPE, "application/json"), (header::CACHE_CONTROL, "no-store")];
    (status, kind, json).into_response()
}

fn text(body: &'static str) -> Response {
    ([(header::CACHE_CONTROL, "no-store")], body).into_response()
}

fn tag(sequence: u64) -> [(HeaderName, String); 1] {
    [(header::ETAG, format!("\"{sequence}\""))]
}

/// Refuses the name of any scene but the one that is served.
fn served(ocean: &Ocean, name: Name) -> Result<(), Problem> {
    let name = name.map_or_else(|_| String::new(), |Path(name)| name);
    let known = ocean.current().timeline.scene().name.clone();
    if name == known {
        return Ok(());
    }
    Err(Problem::not_found(format!("there is no scene {name:?}; this server serves {known:?}")))
}

async fn scenes(State(ocean): Served) -> Response {
    let timeline = ocean.current().timeline;
    let scene = timeline.scene();
    let one = json!({ "name": scene.name, "title": scene.title, "url": format!("/v1/scenes/{}", scene.name) });
    answer(StatusCode::OK, &json!({ "scenes": [one] }))
}

async fn scene(State(ocean): Served, name: Name) -> Result<Response, Problem> {
    served(&ocean, name)?;
    let (current, status) = (ocean.current(), ocean.status());
    let now = current.timeline.scene_at(status.tick);
    let body = json!({
        "scene": SceneFile::from(current.timeline.scene()),
        "epoch": ocean.epoch.to_string(),
        "sequence": current.sequence,
        "layout": hello::layout(&current.timeline, status.tick),
        "warnings": current.timeline.warnings(),
        "state": {
            "tick": status.tick,
            "sequence": status.sequence,
            "hs_m": status.hs_m,
            "wanted_hs_m": current.timeline.wanted_hs_at(status.tick),
            "wind": status.wind,
            "wind_range_mps": status.wind_range_mps,
            "depth_m": status.depth_m,
            "gravity": now.sea.water.gravity,
            "cascades": CascadesFile::from(&now.cascades),
        },
    });
    Ok((tag(current.sequence), answer(StatusCode::OK, &body)).into_response())
}

/// What the sea is like, at most a second ago.
async fn statistics(State(ocean): Served, name: Name) -> Result<Response, Problem> {
    served(&ocean, name)?;
    let (sequence, body) = ocean.statistics().await?;
    Ok((tag(sequence), answer(StatusCode::OK, &body)).into_response())
}

/// The water at points of the world.
async fn water_at(State(ocean): Served, name: Name, body: Body) -> Result<Response, Problem> {
    served(&ocean, name)?;
    Ok(written(StatusCode::OK, probe::answer(&ocean, body).await?))
}

/// What is computed now, and what it costs.
async fn plan(State(ocean): Served, name: Name) -> Result<Response, Problem> {
    served(&ocean, name)?;
    let (sequence, body) = plan::plan(&ocean).await?;
    Ok((tag(sequence), answer(StatusCode::OK, &body)).into_response())
}

/// What the stream errs now.
async fn errors(State(ocean): Served, name: Name, RawQuery(query): RawQuery) -> Result<Response, Problem> {
    served(&ocean, name)?;
    let mut tick = None;
    for (field, value) in pairs(query.as_deref()) {
        let refuse = |bound: &str| Problem::value(field, value.into(), bound);
        match field {
            "tick" => tick = Some(value.parse().map_err(|_| refuse("a whole number"))?),
            _ => return Err(refuse("tick")),
        }
    }
    let (sequence, body) = accuracy::accuracy(&ocean, tick).await?;
    Ok((tag(sequence), answer(StatusCode::OK, &body)).into_response())
}

/// Fields and values of a query.
fn pairs(query: Option<&str>) -> impl Iterator<Item = (&str, &str)> {
    let pairs = query.unwrap_or_default().split('&').filter(|pair| !pair.is_empty());
    pairs.map(|pair| pair.split_once('=').unwrap_or((pair, "")))
}

/// What the budget of milliseconds picked, and why.
async fn budget(State(ocean): Served, name: Name) -> Result<Response, Problem> {
    served(&ocean, name)?;
    Ok(answer(StatusCode::OK, &ocean.budget.told()))
}

async fn set_budget(State(ocean): Served, name: Name, body: Body) -> Result<Response, Problem> {
    served(&ocean, name)?;
    let body = read_body(body, MAX_BODY).await?;
    Ok(answer(StatusCode::ACCEPTED, &Budget::set(&ocean, &body)?))
}

async fn wind(State(ocean): Served, name: Name, headers: HeaderMap, body: Body) -> Result<Response, Problem> {
    served(&ocean, name)?;
    let asked = ChangeBody::wind(&read_body(body, MAX_BODY).await?)?;
    change(&ocean, &headers, asked).await
}

async fn sea(State(ocean): Served, name: Name, headers: HeaderMap, body: Body) -> Result<Response, Problem> {
    served(&ocean, name)?;
    let asked = ChangeBody::sea(&read_body(body, MAX_BODY).await?)?;
    change(&ocean, &headers, asked).await
}

async fn layout(State(ocean): Served, name: Name, headers: HeaderMap, body: Body) -> Result<Response, Problem> {
    served(&ocean, name)?;
    let asked = ChangeBody::layout(&read_body(body, MAX_BODY).await?)?;
    change(&ocean, &headers, asked).await
}

/// Reads the headers that all changes have in common, and proposes the change.
async fn change(ocean: &Arc<Ocean>, headers: &HeaderMap, asked: ChangeBody) -> Result<Response, Problem> {
    let ChangeBody { kind, when, transition_s } = asked;
    let (key, if_match) = (idempotency_key(headers)?, if_match(headers)?);
    let accepted = ocean.propose(Proposal { kind, when, transition_s, key, if_match }).await?;
    let body = json!({ "sequence": accepted.sequence, "effective_tick": accepted.effective_tick });
    Ok((tag(accepted.sequence), answer(StatusCode::ACCEPTED, &body)).into_response())
}

fn idempotency_key(headers: &HeaderMap) -> Result<Option<String>, Problem> {
    let Some(value) = headers.get("idempotency-key") else { return Ok(None) };
    let key = value.to_str().ok().filter(|key| (1..=MAX_KEY).contains(&key.len()));
    let found = || Value::from(String::from_utf8_lossy(value.as_bytes()).into_owned());
    let refused = || Problem::value("Idempotency-Key", found(), format!("1 to {MAX_KEY} visible ASCII characters"));
    key.map(|key| Some(key.to_owned())).ok_or_else(refused)
}

/// Sequences that `If-Match` names; `None` for no header and for `*`.
fn if_match(headers: &HeaderMap) -> Result<Option<Vec<u64>>, Problem> {
    let mut wanted = Vec::new();
    for value in headers.get_all(header::IF_MATCH) {
        for tag in value.to_str().unwrap_or_default().split(',').map(str::trim) {
            if tag == "*" {
                return Ok(None);
            }
            // A tag that is none of ours matches nothing.
            let sequence: Option<u64> =
                tag.strip_prefix('"').and_then(|tag| tag.strip_suffix('"')).and_then(|n| n.parse().ok());
            wanted.extend(sequence);
        }
    }
    Ok(headers.contains_key(header::IF_MATCH).then_some(wanted))
}

async fn log(State(ocean): Served, name: Name, RawQuery(query): RawQuery) -> Result<Response, Problem> {
    served(&ocean, name)?;
    let (mut after, mut limit) = (0, PAGE);
    for (field, value) in pairs(query.as_deref()) {
        let refuse = |bound: &str| Problem::value(field, value.into(), bound);
        match field {
            "after" => after = value.parse().map_err(|_| refuse("a whole number from 0"))?,
            "limit" => {
                let wanted = value.parse().ok().filter(|n| (1..=MAX_PAGE).contains(n));
                limit = wanted.ok_or_else(|| refuse(&format!("a whole number from 1 to {MAX_PAGE}")))?;
            }
            _ => return Err(refuse("after or limit")),
        }
    }
    let store = Arc::clone(&ocean.store);
    let page = spawn_blocking(move || store.page(after, limit)).await;
    let page = page.map_err(|_| Problem::internal("the control log can't be read"))??;
    let sequence = ocean.current().sequence;
    let last = page.last().map_or(after, |change| change.sequence);
    let body = json!({
        "changes": page.iter().map(told).collect::<Vec<_>>(),
        "sequence": sequence,
        "next_after": (last < sequence).then_some(last),
    });
    Ok((tag(sequence), answer(StatusCode::OK, &body)).into_response())
}

async fn time(State(ocean): Served) -> Response {
    let us = ocean.clock.now_us();
    let body = json!({
        "tick": i64::try_from(i128::from(us) * i128::from(TICKS_PER_SECOND) / 1_000_000).unwrap_or(i64::MAX),
        "time_us": us,
        "ticks_per_second": TICKS_PER_SECOND,
        "epoch": ocean.epoch.to_string(),
        "unix_ns_of_tick_0": ocean.epoch.unix_ns,
    });
    answer(StatusCode::OK, &body)
}

async fn readyz(State(ocean): Served) -> Result<Response, Problem> {
    if ocean.is_ready() {
        let engine = ocean.counters();
        let note = engine.backend_note.map(|note| format!("; {note}")).unwrap_or_default();
        let body = format!("ready: {}{note}\n", engine.backend);
        return Ok(([(header::CACHE_CONTROL, "no-store")], body).into_response());
    }
    let detail = "the engine has stopped: no frames are made";
    Err(Problem::new(StatusCode::SERVICE_UNAVAILABLE, "not-ready", "Not ready", detail))
}

async fn page(State(ocean): Served) -> Response {
    ([(header::CONTENT_TYPE, "text/plain; version=0.0.4; charset=utf-8")], metrics::page(&ocean)).into_response()
}

async fn static_file(method: Method, uri: Uri, headers: HeaderMap) -> Result<Response, Problem> {
    match viewer::file(uri.path(), &headers) {
        Some(file) if method == Method::GET || method == Method::HEAD => Ok(file),
        Some(_) => Ok(([(header::ALLOW, "GET, HEAD")], wrong_method(method, uri).await).into_response()),
        None => Err(Problem::not_found(format!("there is nothing at {}", uri.path()))),
    }
}

async fn wrong_method(method: Method, uri: Uri) -> Problem {
    let path = uri.path();
    let of_scene = path.strip_prefix("/v1/scenes/").is_some_and(|name| !name.contains('/'));
    let detail = if of_scene && (method == Method::PUT || method == Method::DELETE) {
        "scenes can't be made or removed while the server runs: it serves the one it was started with".to_owned()
    } else {
        format!("{path} does not take {method}")
    };
    Problem::new(StatusCode::METHOD_NOT_ALLOWED, "wrong-method", "The path does not take this method", detail)
}
