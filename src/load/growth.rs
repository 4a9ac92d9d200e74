//! Whether the server's memory grows: a late stretch of the window beside an early one. Pure.

/// Fewest rows that have quarters.
const LEAST: usize = 4;

/// By how much the median of the last quarter is above that of the second: the first is for what a server takes once.
/// `None` for less than four rows, and when nothing is known of one of the two.
pub fn growth(rows: &[Option<f64>]) -> Option<f64> {
    let quarter = |number: usize| median(&rows[rows.len() * number / 4..rows.len() * (number + 1) / 4]);
    (rows.len() >= LEAST).then(|| Some(quarter(3)? - quarter(1)?))?
}

fn median(values: &[Option<f64>]) -> Option<f64> {
    let mut known: Vec<f64> = values.iter().flatten().copied().collect();
    known.sort_by(f64::total_cmp);
    let below = known.get(known.len().checked_sub(1)? / 2)?;
    Some((below + known.get(known.len() / 2)?) / 2.0)
}
