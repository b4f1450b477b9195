//! The tests of this crate as one program, which builds sooner than one program each.

mod card;
mod mjcf;
mod npz;
mod onnx;
