//! Semantics of small programs.

mod frames;
mod left_alone;
mod moves;
mod unread;

use gcode::{Arc, Dialect, Move, MoveKind, Shiftable, Toolpath, interpret, parse};

fn read_as(dialect: Dialect, text: &str) -> Toolpath {
    match interpret(&parse(text), &dialect.into()) {
        Ok(toolpath) => toolpath,
        Err(error) => panic!("{error}\n{text}"),
    }
}

fn read(text: &str) -> Toolpath {
    read_as(Dialect::Fanuc, text)
}

fn arc(step: &Move) -> Arc {
    match step.kind {
        MoveKind::Arc(arc) => arc,
        other => panic!("no arc: {other:?}"),
    }
}

fn last(toolpath: &Toolpath) -> Move {
    *toolpath.moves.last().expect("there is a move")
}

fn close(a: [f64; 3], b: [f64; 3]) {
    assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9), "{a:?} is not {b:?}");
}

/// Whether the last feed move of `text` is shiftable.
fn shifts(dialect: Dialect, text: &str) -> bool {
    last(&read_as(dialect, &format!("G21 G90 G17\nG0 X0 Y0 Z0\n{text}"))).shiftable == Shiftable::Yes
}

/// Whether each feed move is shiftable.
fn feeds(text: &str, dialect: Dialect) -> Vec<Shiftable> {
    let path = interpret(&parse(text), &dialect.into()).expect("accepted");
    path.moves.iter().filter(|m| m.is_feed()).map(|m| m.shiftable).collect()
}
