//! What leaves for other programs: the body as MJCF for MuJoCo, a controller as ONNX or with a model card, a recording as
//! NPZ. Each format is written directly, without the library of the program that reads it; the tests of
//! the Python package hold each file against that library.

mod card;
mod mjcf;
mod npz;
mod onnx;
mod protobuf;

pub use card::{CardError, card};
pub use mjcf::{NominalContact, mjcf};
pub use npz::npz;
pub use onnx::{OnnxError, onnx};
