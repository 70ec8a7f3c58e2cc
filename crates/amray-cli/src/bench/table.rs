//! What `amray bench` prints for people: a table of frames per second and one of the rest for each transfer function.

use std::fmt::Write;
use std::iter::once;

use super::report::{Report, Row};
use crate::number::{bytes, grouped};

pub(super) fn text(report: &Report) -> String {
    let mut text = String::new();
    write(&mut text, report).expect("writing to a string cannot fail");
    text
}

fn write(out: &mut String, report: &Report) -> std::fmt::Result {
    let Report { data, machine, index, .. } = report;
    let path = data.path.display();
    writeln!(out, "{path}: {}, {} levels, {} bricks", data.field, data.levels, grouped(data.bricks as u64))?;
    writeln!(out, "{} cells, {} leaf cells, {}", grouped(data.cells), grouped(data.leaf_cells), bytes(data.bytes))?;
    let regions = grouped(index.regions as u64);
    writeln!(out, "index: {regions} regions, {}, built in {:.4} s", bytes(index.bytes), index.seconds)?;
    let processor = machine.processor.as_deref().unwrap_or("unknown processor");
    writeln!(out, "{processor}, {} threads, {}", machine.threads, machine.instructions)?;
    for rows in report.rows.chunk_by(|a, b| a.transfer_function == b.transfer_function) {
        let [width, height] = report.size;
        writeln!(out, "\n{}: frames per second at {width}x{height}", rows[0].transfer_function)?;
        write_frames(out, rows)?;
        writeln!(out)?;
        write_rest(out, rows)?;
    }
    Ok(())
}

/// A number of a row.
type Quantity = fn(&Row) -> f64;

/// A column for each level.
fn write_frames(out: &mut String, rows: &[Row]) -> std::fmt::Result {
    let mut levels: Vec<usize> = rows.iter().map(|row| row.max_level).collect();
    levels.sort_unstable();
    levels.dedup();
    let columns: String =
        levels.iter().fold(String::new(), |line, level| line + &format!(" {:>9}", format!("0..{level}")));
    writeln!(out, "method   threads  levels       {columns}")?;
    for of_method in rows.chunk_by(|a, b| a.method == b.method) {
        let mut counts: Vec<usize> = of_method.iter().map(|row| row.threads).collect();
        counts.sort_unstable();
        counts.dedup();
        for threads in counts {
            let of_threads = || of_method.iter().filter(|row| row.threads == threads);
            let quantities: [(&str, Quantity); 4] = [
                ("march", |row| row.march_fps),
                ("query", |row| row.query_fps),
                ("ratio", |row| row.ratio),
                ("same samples", |row| row.ratio_same_samples),
            ];
            let heads = once((of_method[0].method, threads.to_string())).chain((0..3).map(|_| ("", String::new())));
            for ((method, threads), (name, quantity)) in heads.zip(quantities) {
                let cells: String =
                    of_threads().fold(String::new(), |line, row| line + &format!(" {:>9.2}", quantity(row)));
                writeln!(out, "{method:<8} {threads:>7}  {name:<13}{cells}")?;
            }
        }
    }
    Ok(())
}

/// A line for each row.
fn write_rest(out: &mut String, rows: &[Row]) -> std::fmt::Result {
    writeln!(out, "                       million samples/s    samples                          PSNR, dB")?;
    writeln!(out, "method   levels threads   march    query    per ray  interior  skipped    march    query")?;
    for row in rows {
        let psnr = |psnr: Option<f64>| psnr.map_or_else(|| "equal".into(), |psnr| format!("{psnr:.1}"));
        writeln!(
            out,
            "{:<8} {:>6} {:>7} {:>7.1} {:>8.1} {:>10.1} {:>7.1} % {:>6.1} % {:>8} {:>8}",
            row.method,
            format!("0..{}", row.max_level),
            row.threads,
            row.march_msamples_per_s,
            row.query_msamples_per_s,
            row.samples_per_ray,
            100.0 * row.interior_share,
            100.0 * row.skipped_share,
            psnr(row.march_psnr),
            psnr(row.query_psnr),
        )?;
    }
    Ok(())
}
