//! Kinds of content that are no milling programs.

use thiserror::Error;

/// Content that is no milling program in G-code or Heidenhain dialogue. Displayed as a sentence with the remedy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Error)]
pub enum Foreign {
    /// No bytes but blanks.
    #[error("the file is empty; check that it was exported or copied completely")]
    Empty,
    /// Text in UTF-16.
    #[error("the file is text in UTF-16; save it as UTF-8 or ASCII")]
    Utf16,
    /// Binary data of no known kind.
    #[error("the file holds binary data; give the part program as text")]
    Binary,
    /// A PDF document or an image.
    #[error("the file is a document or an image; give the part program as text")]
    Document,
    /// HTML, XML or SVG.
    #[error("the file is HTML, XML or SVG; give the part program that the CAM system writes for the control")]
    Markup,
    /// DXF, DWG, STEP, IGES or STL.
    #[error("the file is a {0} model; generate toolpaths in a CAM system and give the part program that it writes")]
    Model(&'static str),
    /// DSTV NC1 data of a steel profile.
    #[error("the file is NC1 (DSTV) data of a steel profile; give the part program that the machine's CAM system makes of it")]
    Dstv,
    /// DIN/ISO programming of Heidenhain controls.
    #[error(
        "the program is DIN/ISO for a Heidenhain control; run the CAM system's post-processor for dialogue (Klartext) or G-code"
    )]
    HeidenhainIso,
    /// High-level blocks of Fagor controls, which stand in parentheses as comments do.
    #[error(
        "the program has high-level blocks of a Fagor control, such as (CALL 5) or (RPT N60,N70); write it without them, for instance \
         with the CAM system, or take them out where they are comments"
    )]
    Fagor,
    /// Commands of OSAI and Acramatic controls, which stand in parentheses as comments do.
    #[error(
        "the program has commands of an OSAI or Acramatic control in parentheses, such as (UTO,1,X10), (ROT,45) or (CLS,P1): they shift, turn, \
         repeat or call moves; write it without them, for instance with the CAM system, or take them out where they are comments"
    )]
    Parenthesised,
    /// Mazatrol.
    #[error("the program is Mazatrol; write it as EIA/ISO G-code on the control or in the CAM system")]
    Mazatrol,
    /// APT or CL data.
    #[error("the file is APT or CL data (GOTO/); run the CAM system's post-processor and give the part program that it writes")]
    CutterLocation,
    /// Plotter commands.
    #[error("the file is for a plotter (HP-GL); write the toolpath as G-code")]
    Plotter,
    /// A program for a 3D printer.
    #[error("the program is for a 3D printer (E words, nozzle temperature); only milling programs can be compensated")]
    Printer,
    /// A program for a lathe.
    #[error(
        "the program is for a lathe ({0}): its X words may be diameters, and only milling programs can be compensated; \
         LinuxCNC programs in radii state G8"
    )]
    Lathe(&'static str),
    /// Settings, parameters or offsets of a control.
    #[error("the file is a backup of a control's settings; give the part program")]
    Settings,
    /// An INI file, as of LinuxCNC.
    #[error("the file is an INI file, as of LinuxCNC; give the part program")]
    Ini,
    /// A LinuxCNC HAL file.
    #[error("the file is a LinuxCNC HAL file; give the part program")]
    Hal,
    /// A tool table.
    #[error("the file is a tool table; give the part program")]
    ToolTable,
}
