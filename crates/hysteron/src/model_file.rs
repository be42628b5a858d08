//! The versioned model file.
