//! rt-render
