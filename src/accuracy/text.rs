//! Numbers and names as they are shown.

/// A number with three significant digits, or all of its whole ones: 0, 1.20e-7, 0.00123, 4.57, 1234.
pub fn significant(value: f64) -> String {
    // Rounded first, so that 9.999 has the digits of 10.
    let rounded: f64 = format!("{value:.2e}").parse().unwrap_or(value);
    let power = rounded.abs().log10().floor();
    if value == 0.0 {
        "0".to_owned()
    } else if power < -3.0 {
        format!("{value:.2e}")
    } else {
        format!("{value:.*}", (2.0 - power).max(0.0) as usize)
    }
}

/// Text inside an element or an attribute.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::significant;

    #[test]
    fn numbers_have_three_significant_digits() {
        let shown = [0.0, 1.2e-7, 0.0012345, 0.99999, 4.5678, 99.96, 1234.4, -0.25].map(significant);
        assert_eq!(shown, ["0", "1.20e-7", "0.00123", "1.00", "4.57", "100", "1234", "-0.250"]);
    }
}
