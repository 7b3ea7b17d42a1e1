// rustc -O -o engine engine.rs
use std::io::{stdin, stdout, BufRead, Write};

fn numbers(line: &str, key: &str) -> Vec<f64> { // the numbers between this key and the next one
    let Some(at) = line.find(&format!("\"{key}\"")) else { return vec![] };
    let text = line[at + key.len() + 2..].split('"').next().unwrap();
    text.split(|c| ":,[]{} ".contains(c)).filter_map(|word| word.parse().ok()).collect()
}
fn product(p: [f64; 4], q: [f64; 4]) -> [f64; 4] {
    [p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3], p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
     p[0] * q[2] + p[2] * q[0] + p[3] * q[1] - p[1] * q[3], p[0] * q[3] + p[3] * q[0] + p[1] * q[2] - p[2] * q[1]]
}
fn conjugate(q: [f64; 4]) -> [f64; 4] { [q[0], -q[1], -q[2], -q[3]] }

fn step(s: &mut [f64], i: &[f64], gravity: &[f64], dt: f64) {
    let q = [s[3], s[4], s[5], s[6]];
    let [_, a, b, c] = product(product(conjugate(q), [0.0, s[10], s[11], s[12]]), q);
    let body = [0.0, a + dt * (i[1] - i[2]) / i[0] * b * c, b + dt * (i[2] - i[0]) / i[1] * c * a,
                c + dt * (i[0] - i[1]) / i[2] * a * b];
    let w = product(product(q, body), conjugate(q));
    let speed = (w[1] * w[1] + w[2] * w[2] + w[3] * w[3]).sqrt();
    let part = if speed > 0.0 { (dt / 2.0 * speed).sin() / speed } else { 0.0 };
    let turned = product([(dt / 2.0 * speed).cos(), part * w[1], part * w[2], part * w[3]], q);
    let length = turned.iter().map(|each| each * each).sum::<f64>().sqrt();
    for k in 0..4 { s[3 + k] = turned[k] / length; }
    for k in 0..3 {
        s[10 + k] = w[1 + k];
        s[7 + k] += dt * gravity.get(k).unwrap_or(&0.0);
        s[k] += dt * s[7 + k];
    }
}
fn main() {
    let (mut moments, mut gravity, mut states) = (vec![], vec![], vec![]);
    for line in stdin().lock().lines().map_while(Result::ok) {
        let mut answer = "{}".to_string();
        if line.contains("\"build\"") { (moments, gravity) = (numbers(&line, "moments"), numbers(&line, "gravity")); }
        if line.contains("\"write\"") { states = numbers(&line, "states"); }
        if line.contains("\"advance\"") {
            let (started, n, dt) = (std::time::Instant::now(), numbers(&line, "n")[0] as u64, numbers(&line, "dt")[0]);
            for state in states.chunks_mut(13) { for _ in 0..n { step(state, &moments, &gravity, dt); } }
            answer = format!("{{\"ns\": {}}}", started.elapsed().as_nanos());
        }
        if line.contains("\"read\"") {
            let text = |n: &f64| if n.is_finite() { format!("{n:?}") } else { "null".into() };
            let row = |state: &[f64]| state.iter().map(text).collect::<Vec<_>>().join(", ");
            answer = format!("{{\"states\": [[{}]]}}", states.chunks(13).map(row).collect::<Vec<_>>().join("], ["));
        }
        println!("{answer}");
        stdout().flush().unwrap();
    }
}
