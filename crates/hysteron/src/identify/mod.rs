//! From records to a model.
