// mcs -optimize engine.cs; command = ["mono", "engine.exe"]; or: dotnet build -c Release, and the file that it writes
using System;
using System.Diagnostics;
using System.Globalization;
using System.Linq;

static class Engine {
  static double[] Numbers(string line, string key) { // the numbers between this key and the next one
    int at = line.IndexOf('"' + key + '"');
    if (at < 0) return new double[0];
    var words = line.Substring(at + key.Length + 2).Split('"')[0].Split(":,[]{} ".ToArray(), StringSplitOptions.RemoveEmptyEntries);
    return words.Select(word => double.Parse(word, CultureInfo.InvariantCulture)).ToArray();
  }
  static double[] Product(double[] p, double[] q) => new[] {
    p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3], p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
    p[0] * q[2] + p[2] * q[0] + p[3] * q[1] - p[1] * q[3], p[0] * q[3] + p[3] * q[0] + p[1] * q[2] - p[2] * q[1] };
  static double[] Conjugate(double[] q) => new[] { q[0], -q[1], -q[2], -q[3] };

  static void Step(double[] all, int at, double[] I, double[] g, double dt) {
    var s = new ArraySegment<double>(all, at, 13).ToArray();
    double[] q = { s[3], s[4], s[5], s[6] }, b = Product(Product(Conjugate(q), new[] { 0, s[10], s[11], s[12] }), q);
    b = new[] { 0, b[1] + dt * (I[1] - I[2]) / I[0] * b[2] * b[3], b[2] + dt * (I[2] - I[0]) / I[1] * b[3] * b[1],
                b[3] + dt * (I[0] - I[1]) / I[2] * b[1] * b[2] };
    var w = Product(Product(q, b), Conjugate(q));
    double speed = Math.Sqrt(w[1] * w[1] + w[2] * w[2] + w[3] * w[3]), part = speed > 0 ? Math.Sin(dt / 2 * speed) / speed : 0;
    q = Product(new[] { Math.Cos(dt / 2 * speed), part * w[1], part * w[2], part * w[3] }, q);
    double length = Math.Sqrt(q.Sum(each => each * each));
    for (int i = 0; i < 4; i++) all[at + 3 + i] = q[i] / length;
    for (int i = 0; i < 3; i++) {
      all[at + 10 + i] = w[1 + i];
      all[at + 7 + i] += g.Length > 0 ? dt * g[i] : 0;
      all[at + i] += dt * all[at + 7 + i];
    }
  }
  static string Text(double number) =>
    double.IsNaN(number) || double.IsInfinity(number) ? "null" : number.ToString("G17", CultureInfo.InvariantCulture);

  static void Main() {
    double[] moments = { }, gravity = { }, states = { };
    for (string line; (line = Console.ReadLine()) != null;) {
      string answer = "{}";
      if (line.Contains("\"build\"")) (moments, gravity) = (Numbers(line, "moments"), Numbers(line, "gravity"));
      if (line.Contains("\"write\"")) states = Numbers(line, "states");
      if (line.Contains("\"advance\"")) {
        var clock = Stopwatch.StartNew();
        double n = Numbers(line, "n")[0], dt = Numbers(line, "dt")[0];
        for (int at = 0; at < states.Length; at += 13)
          for (int k = 0; k < n; k++) Step(states, at, moments, gravity, dt);
        answer = "{\"ns\": " + Text(clock.ElapsedTicks * 1e9 / Stopwatch.Frequency) + "}";
      }
      if (line.Contains("\"read\"")) {
        var rows = Enumerable.Range(0, states.Length / 13).Select(row => string.Join(", ", states.Skip(13 * row).Take(13).Select(Text)));
        answer = "{\"states\": [[" + string.Join("], [", rows) + "]]}";
      }
      Console.WriteLine(answer);
    }
  }
}
