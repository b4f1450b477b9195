//! Contract: the ONNX file of a controller is a protocol-buffer message that can be read to its end, holds
//! the graph's nodes in order, the scale and the means' weights alone, and the same bytes each time. That
//! it is valid ONNX and computes the policy is tested with onnx and onnxruntime:
//! `crates/gaitshift-python/tests/test_onnx.py`.

use gaitshift_experiment::Controller;
use gaitshift_export::onnx;

/// The fields of a message: number and content (empty for what is no bytes).
fn fields(mut bytes: &[u8]) -> Vec<(u64, &[u8])> {
    fn varint(bytes: &mut &[u8]) -> u64 {
        let mut value = 0;
        for shift in (0..).step_by(7) {
            let (&byte, rest) = bytes.split_first().unwrap();
            *bytes = rest;
            value |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                break;
            }
        }
        value
    }
    let mut all = Vec::new();
    while !bytes.is_empty() {
        let key = varint(&mut bytes);
        let length = match key & 7 {
            0 => {
                varint(&mut bytes);
                0
            }
            2 => varint(&mut bytes) as usize,
            5 => 4,
            kind => panic!("unexpected kind {kind}"),
        };
        let (content, rest) = bytes.split_at(length);
        all.push((key >> 3, content));
        bytes = rest;
    }
    all
}

fn only<'a>(fields: &[(u64, &'a [u8])], number: u64) -> Vec<&'a [u8]> {
    fields
        .iter()
        .filter(|field| field.0 == number)
        .map(|field| field.1)
        .collect()
}

#[test]
fn the_graph_scales_computes_and_squashes() {
    let controller = Controller::shipped().unwrap();
    let bytes = onnx(&controller).unwrap();
    assert_eq!(bytes, onnx(&controller).unwrap());
    let model = fields(&bytes);
    let graph = fields(only(&model, 7)[0]);
    let operators: Vec<String> = only(&graph, 1)
        .into_iter()
        .map(|node| String::from_utf8(only(&fields(node), 4)[0].to_vec()).unwrap())
        .collect();
    assert_eq!(operators[0], "Mul");
    assert_eq!(operators[operators.len() - 2..], ["Gemm", "Tanh"]);
    let linear = operators.iter().filter(|name| *name == "Gemm").count();
    assert_eq!(linear, controller.policy.shape().hidden.len() + 1);
    // Each constant holds as many numbers as its extents say.
    let constants = only(&graph, 5);
    let data = |name: &str| {
        let constant = constants
            .iter()
            .map(|constant| fields(constant))
            .find(|constant| only(constant, 8)[0] == name.as_bytes())
            .unwrap_or_else(|| panic!("{name}"));
        only(&constant, 9)[0].len() / 4
    };
    assert_eq!(data("observation_scale"), 14);
    let last = *controller.policy.shape().hidden.last().unwrap();
    assert_eq!(data("mean.weight"), 2 * last);
    assert_eq!(data("mean.bias"), 2);
    assert!(only(&model, 14).len() >= 5);
}
