//! SINUMERIK programs (840D, 828D, 808D, ONE): their words, expressions and statements.

pub(crate) mod lexer;
pub(crate) mod names;
pub(crate) mod scan;
pub(crate) mod signs;
