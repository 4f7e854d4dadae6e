//! `points.csv`: one row per point.

use super::Point;

/// The table with its header line.
///
/// # Errors
/// None that a point can cause.
pub fn csv(points: &[Point]) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    points.iter().try_for_each(|point| writer.serialize(point))?;
    writer.into_inner().map_err(|e| e.into_error().into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_a_point() {
        let point = Point {
            id: "a,b".to_owned(),
            psnr: Some(31.5),
            unsteady: Some(true),
            ..Point::default()
        };
        let text = String::from_utf8(csv(std::slice::from_ref(&point)).unwrap()).unwrap();
        let [header, row] = text.lines().collect::<Vec<_>>()[..] else { panic!("{text}") };
        assert!(header.starts_with("id,program,scene,method,model"), "{header}");
        assert!(row.starts_with("\"a,b\",,"), "{row}");
        let back: Vec<Point> =
            csv::Reader::from_reader(text.as_bytes()).deserialize().map(Result::unwrap).collect();
        assert_eq!(back, [point]);
    }
}
