//! Named tensors of 32-bit floats as the bytes of a safetensors file, with a text beside them.

use gaitshift_sac::NamedTensor;
use safetensors::{Dtype, SafeTensorError, SafeTensors, tensor::TensorView};
use std::collections::HashMap;

/// The metadata's entry that holds the text.
const KEY: &str = "gaitshift";

/// The bytes of a file.
///
/// # Errors
/// As a text, if they cannot be written.
pub(crate) fn to_bytes(tensors: &[NamedTensor<f32>], text: String) -> Result<Vec<u8>, String> {
    let bytes: Vec<Vec<u8>> = tensors
        .iter()
        .map(|t| t.values.iter().flat_map(|v| v.to_le_bytes()).collect())
        .collect();
    let views = tensors
        .iter()
        .zip(&bytes)
        .map(|(t, bytes)| {
            let view = TensorView::new(Dtype::F32, t.shape.clone(), bytes)?;
            Ok((t.name.as_str(), view))
        })
        .collect::<Result<Vec<_>, SafeTensorError>>()
        .map_err(|e| e.to_string())?;
    let metadata = HashMap::from([(KEY.to_owned(), text)]);
    safetensors::serialize(views, Some(metadata)).map_err(|e| e.to_string())
}

/// The text of a file.
///
/// # Errors
/// A file that is none of this program, in words that go on from "it" in a sentence.
pub(crate) fn text(bytes: &[u8]) -> Result<String, String> {
    let (_, header) = SafeTensors::read_metadata(bytes).map_err(damaged)?;
    let text = header.metadata().as_ref().and_then(|m| m.get(KEY)).cloned();
    text.ok_or_else(|| "it is a safetensors file of another program".to_owned())
}

/// The tensors of a file.
///
/// # Errors
/// As [`text`], and a tensor of other numbers.
pub(crate) fn tensors(file: &SafeTensors<'_>) -> Result<Vec<NamedTensor<f32>>, String> {
    let tensors = file.iter().map(|(name, view)| {
        if view.dtype() != Dtype::F32 {
            return Err(format!("its tensor `{name}` is not of 32-bit floats"));
        }
        let (numbers, _) = view.data().as_chunks::<4>();
        Ok(NamedTensor {
            name: name.to_owned(),
            shape: view.shape().to_vec(),
            values: numbers.iter().map(|b| f32::from_le_bytes(*b)).collect(),
        })
    });
    tensors.collect()
}

/// The file, its tensors not yet copied.
///
/// # Errors
/// As [`text`].
pub(crate) fn open(bytes: &[u8]) -> Result<SafeTensors<'_>, String> {
    SafeTensors::deserialize(bytes).map_err(damaged)
}

fn damaged(error: SafeTensorError) -> String {
    format!("it is not a safetensors file, or it is truncated ({error})")
}
