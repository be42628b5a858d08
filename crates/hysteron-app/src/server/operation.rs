//! Operations of the interface: each is a route and its description at once.

use std::sync::Arc;

use axum::handler::Handler;
use axum::routing::{MethodFilter, MethodRouter, on};
use schemars::{JsonSchema, Schema, SchemaGenerator};

use super::{Shared, routes};

/// Schema of a type.
type SchemaOf = fn(&mut SchemaGenerator) -> Schema;

/// What an operation answers with.
#[derive(Clone, Copy)]
pub(super) enum Answers {
    /// JSON.
    Json(SchemaOf),
    /// Something else, of this media type.
    Media(&'static str),
    /// Nothing.
    Nothing,
}

/// What it is sent.
#[derive(Clone, Copy)]
pub(super) enum Takes {
    /// Nothing.
    Nothing,
    /// JSON.
    Json(SchemaOf),
    /// The bytes of a file.
    Bytes,
}

/// An operation.
pub(super) struct Operation {
    pub method: &'static str,
    pub path: &'static str,
    pub summary: &'static str,
    pub status: u16,
    pub query: Option<SchemaOf>,
    pub takes: Takes,
    pub answers: Answers,
    pub route: MethodRouter<Arc<Shared>>,
}

impl Operation {
    fn new<H, T>(
        method: (&'static str, MethodFilter),
        path: &'static str,
        summary: &'static str,
        handler: H,
    ) -> Self
    where
        H: Handler<T, Arc<Shared>>,
        T: 'static,
    {
        Self {
            method: method.0,
            path,
            summary,
            status: 200,
            query: None,
            takes: Takes::Nothing,
            answers: Answers::Nothing,
            route: on(method.1, handler),
        }
    }

    pub(super) fn get<H, T>(path: &'static str, summary: &'static str, handler: H) -> Self
    where
        H: Handler<T, Arc<Shared>>,
        T: 'static,
    {
        Self::new(("get", MethodFilter::GET), path, summary, handler)
    }

    pub(super) fn post<H, T>(path: &'static str, summary: &'static str, handler: H) -> Self
    where
        H: Handler<T, Arc<Shared>>,
        T: 'static,
    {
        Self::new(("post", MethodFilter::POST), path, summary, handler)
    }

    pub(super) fn patch<H, T>(path: &'static str, summary: &'static str, handler: H) -> Self
    where
        H: Handler<T, Arc<Shared>>,
        T: 'static,
    {
        Self::new(("patch", MethodFilter::PATCH), path, summary, handler)
    }

    pub(super) fn delete<H, T>(path: &'static str, summary: &'static str, handler: H) -> Self
    where
        H: Handler<T, Arc<Shared>>,
        T: 'static,
    {
        Self::new(("delete", MethodFilter::DELETE), path, summary, handler)
    }

    pub(super) fn answers<T: JsonSchema>(self) -> Self {
        Self { answers: Answers::Json(SchemaGenerator::subschema_for::<T>), ..self }
    }

    pub(super) fn answers_with(self, media: &'static str) -> Self {
        Self { answers: Answers::Media(media), ..self }
    }

    pub(super) fn takes<T: JsonSchema>(self) -> Self {
        Self { takes: Takes::Json(SchemaGenerator::subschema_for::<T>), ..self }
    }

    pub(super) fn takes_bytes(self) -> Self {
        Self { takes: Takes::Bytes, ..self }
    }

    pub(super) fn asks<T: JsonSchema>(self) -> Self {
        Self { query: Some(|generator| generator.root_schema_for::<T>()), ..self }
    }

    pub(super) fn with_status(self, status: u16) -> Self {
        Self { status, ..self }
    }
}

/// Every operation of the interface.
pub(super) fn all() -> Vec<Operation> {
    let mut all = routes::workspace::operations();
    all.extend(routes::records::operations());
    all.extend(routes::jobs::operations());
    all.extend(routes::models::operations());
    all.extend(routes::follow::operations());
    all.extend(routes::bench::operations());
    all.extend(routes::reports::operations());
    all
}
