//! `prism bench`: that it says everything it has to say. How fast anything is, a shared machine cannot tell.

mod common;

use std::fs;

use common::{folder, prism};

/// Rows of the table, by how they begin, and how many there are of each.
const ROWS: [(&str, usize); 18] = [
    ("memory of the shell", 1),
    ("memory of the micro-mesh, ", 2),
    ("micro-mesh's memory over the shell's, ", 2),
    ("memory of diced triangles", 2),
    ("0.5 footprints: micro-mesh", 4),
    ("0.5 footprints: diced", 2),
    ("0.5 footprints: ours", 1),
    ("0.5 footprints: times faster than the micro-mesh culled by cluster", 1),
    ("0.5 footprints: times faster than the fastest baseline", 1),
    ("0.1 footprints: micro-mesh", 4),
    ("0.1 footprints: diced", 2),
    ("0.1 footprints: ours", 1),
    ("0.1 footprints: times faster than the micro-mesh culled by cluster", 1),
    ("0.1 footprints: times faster than the fastest baseline", 1),
    ("floor: ", 2),
    ("ours over the floor: ", 2),
    ("4608 triangles for 2304", 2),
    ("same detail in a map of 1024²", 2),
];

/// The fields of a row, in which quoted commas stand.
fn fields(line: &str) -> Vec<String> {
    let mut fields = vec![String::new()];
    let mut quoted = false;
    for c in line.chars() {
        match c {
            '"' => quoted = !quoted,
            ',' if !quoted => fields.push(String::new()),
            c => fields.last_mut().expect("one").push(c),
        }
    }
    fields
}

#[test]
fn a_quick_run_prints_every_row() {
    let folder = folder();
    let call = prism("bench --quick --size 96x54 --rounds 2 --validation core --csv rows.csv");
    let outcome = call.within(folder.path()).succeeds();
    let csv = fs::read_to_string(folder.path().join("rows.csv")).expect("the CSV");
    let rows: Vec<Vec<String>> = csv.lines().skip(1).map(fields).collect();
    for (begin, count) in ROWS.into_iter().chain([("8 times finer detail", 2)]) {
        let found = rows.iter().filter(|row| row[0].starts_with(begin)).count();
        assert_eq!(found, count, "rows '{begin}' in\n{csv}");
    }
    assert_eq!(rows.len(), ROWS.iter().map(|(_, count)| count).sum::<usize>() + 2, "{csv}");
    let table: Vec<&str> = outcome.stdout.lines().filter(|line| line.starts_with("| ")).collect();
    assert_eq!(table.len(), rows.len() + 1, "a header and the same rows\n{}", outcome.stdout);
    assert!(outcome.stdout.contains("96x54; 2 rounds of"), "{}", outcome.stdout);
    for row in &rows {
        let [name, .., p99, _, low, median, high, _, target, verdict] = &row[..] else { panic!("{row:?}") };
        if verdict != "not measured" {
            let [low, median, high] = [low, median, high].map(|v| v.parse::<f64>().expect("a number"));
            assert!(0.0 < low && low <= median && median <= high, "{row:?}");
        }
        assert_eq!(verdict == "met" || verdict == "MISSED", !target.is_empty() && verdict != "not measured", "{row:?}");
        // Whoever competes is within the error of the contest.
        if let Some((error, _)) = name.split_once(" footprints: ").filter(|_| !p99.is_empty()) {
            let limit: f64 = error.parse().expect("an error");
            assert!(p99.parse::<f64>().expect("a figure") <= limit, "{row:?}");
        }
    }
    let measured = |name: &str| rows.iter().any(|row| row[0].starts_with(name) && !row[5].is_empty());
    assert!(measured("0.1 footprints: times faster") && measured("floor: normal-mapped"), "{csv}");
}

#[test]
fn wrong_words_are_refused() {
    for words in ["--errors 0", "--errors 0.5,x", "--rounds 0", "--size 0x9", "--gpu nonesuch"] {
        let outcome = prism("bench --quick").words(words).run();
        assert!([2, 77].contains(&outcome.code) && outcome.stdout.is_empty(), "{words}: {outcome}");
    }
    let outcome = prism("bench --quick --csv /no/such/folder/rows.csv").run();
    assert!(outcome.code == 1 && outcome.stderr.contains("/no/such/folder"), "{outcome}");
}
