//! Copies of the examples in the repository, and what may be wrong with them.

use std::path::Path;

use crate::temp_folder::TempFolder;

/// Copies those runs of an example whose names contain one of these parts.
pub fn runs_of(temp: &TempFolder, example: &str, parts: &[&str], to: &str) {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples").join(example);
    std::fs::create_dir_all(temp.path(&format!("{to}/runs"))).unwrap();
    let text = std::fs::read_to_string(from.join("robot.toml")).unwrap();
    let robot = text.split("[[run]]").next().unwrap();
    temp.write(&format!("{to}/robot.toml"), robot);
    for entry in std::fs::read_dir(from.join("runs")).unwrap() {
        let file = entry.unwrap().path();
        let name = file.file_name().unwrap().to_str().unwrap().to_owned();
        if parts.iter().any(|part| name.contains(part)) {
            std::fs::copy(&file, temp.path(&format!("{to}/runs/{name}"))).unwrap();
        }
    }
}

/// The cells of a run's file, each row after the one of the names.
pub type Rows = Vec<Vec<String>>;

/// Changes the rows of every run; `change` is given the names of the columns.
pub fn change_runs(temp: &TempFolder, campaign: &str, change: impl Fn(&[String], &mut Rows)) {
    for entry in std::fs::read_dir(temp.path(&format!("{campaign}/runs"))).unwrap() {
        let file = entry.unwrap().path();
        let text = std::fs::read_to_string(&file).unwrap();
        let cells = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<String>>();
        let mut rows: Rows = text.lines().map(cells).collect();
        let names = rows.remove(0);
        change(&names, &mut rows);
        rows.insert(0, names);
        let lines: Vec<String> = rows.iter().map(|row| row.join(",") + "\n").collect();
        std::fs::write(&file, lines.concat()).unwrap();
    }
}

/// Changes the numbers of a column.
pub fn change_column(
    temp: &TempFolder,
    campaign: &str,
    column: &str,
    change: impl Fn(f64) -> String,
) {
    change_runs(temp, campaign, |names, rows| {
        let index = names.iter().position(|name| name == column).unwrap();
        for cell in rows.iter_mut().map(|row| &mut row[index]) {
            if let Ok(value) = cell.parse() {
                *cell = change(value);
            }
        }
    });
}

/// Poses by a clock of their own, which is this far ahead of that of the wheels.
pub fn shift_poses(temp: &TempFolder, campaign: &str, by_s: f64) {
    const POSE: [&str; 3] = ["x_m", "y_m", "heading_rad"];
    change_runs(temp, campaign, |names, rows| {
        let is_pose = |k: usize| POSE.contains(&names[k].as_str());
        let mut poses = rows.clone();
        poses.retain(|row| row.iter().enumerate().any(|(k, cell)| is_pose(k) && !cell.is_empty()));
        for row in &mut poses {
            for (_, cell) in row.iter_mut().enumerate().skip(1).filter(|(k, _)| !is_pose(*k)) {
                cell.clear();
            }
            // Between two samples of the wheels, so that no two rows have one time.
            row[0] = format!("{:.6}", row[0].parse::<f64>().unwrap() + by_s + 1e-4);
        }
        for row in rows.iter_mut() {
            row.iter_mut().enumerate().filter(|(k, _)| is_pose(*k)).for_each(|(_, cell)| {
                cell.clear();
            });
        }
        rows.extend(poses);
        let time = |row: &Vec<String>| row[0].parse::<f64>().unwrap();
        rows.sort_by(|a, b| time(a).total_cmp(&time(b)));
    });
}
