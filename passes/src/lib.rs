//! The passes of robovec.
