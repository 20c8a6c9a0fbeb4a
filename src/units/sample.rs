//! Figures of samples.

/// The mean; `None` of none.
pub fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// The root mean square; `None` of none.
pub fn rms(values: impl Iterator<Item = f64>) -> Option<f64> {
    mean(&values.map(|value| value * value).collect::<Vec<_>>()).map(f64::sqrt)
}
