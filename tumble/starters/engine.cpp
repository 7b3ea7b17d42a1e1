// g++ -O2 -o engine engine.cpp
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <sstream>
#include <vector>
using Numbers = std::vector<double>;
using Quaternion = std::array<double, 4>;

Numbers numbers(const std::string& line, const std::string& key) {  // the numbers between this key and the next one
  Numbers found;
  auto at = line.find('"' + key + '"');
  if (at == std::string::npos) return found;
  auto from = at + key.size() + 2;
  std::string text = line.substr(from, line.find('"', from) - from);
  for (char& c : text) if (std::strchr(":,[]{}", c)) c = ' ';
  std::istringstream in(text);
  for (double number; in >> number;) found.push_back(number);
  return found;
}
Quaternion product(const Quaternion& p, const Quaternion& q) {
  return {p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3], p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
          p[0] * q[2] + p[2] * q[0] + p[3] * q[1] - p[1] * q[3], p[0] * q[3] + p[3] * q[0] + p[1] * q[2] - p[2] * q[1]};
}
Quaternion conjugate(const Quaternion& q) { return {q[0], -q[1], -q[2], -q[3]}; }

void step(double* s, const Numbers& I, const Numbers& g, double dt) {
  Quaternion q{s[3], s[4], s[5], s[6]}, b = product(product(conjugate(q), {0, s[10], s[11], s[12]}), q);
  b = {0, b[1] + dt * (I[1] - I[2]) / I[0] * b[2] * b[3], b[2] + dt * (I[2] - I[0]) / I[1] * b[3] * b[1],
       b[3] + dt * (I[0] - I[1]) / I[2] * b[1] * b[2]};
  Quaternion w = product(product(q, b), conjugate(q));
  double speed = std::hypot(w[1], w[2], w[3]), part = speed ? std::sin(dt / 2 * speed) / speed : 0;
  q = product({std::cos(dt / 2 * speed), part * w[1], part * w[2], part * w[3]}, q);
  double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (int i = 0; i < 4; i++) s[3 + i] = q[i] / length;
  for (int i = 0; i < 3; i++) s[10 + i] = w[1 + i], s[7 + i] += g.empty() ? 0 : dt * g[i], s[i] += dt * s[7 + i];
}

int main() {
  Numbers moments, gravity, states;
  for (std::string line; std::getline(std::cin, line);) {
    std::string answer = "{}";
    if (line.find("\"build\"") != line.npos) moments = numbers(line, "moments"), gravity = numbers(line, "gravity");
    if (line.find("\"write\"") != line.npos) states = numbers(line, "states");
    if (line.find("\"advance\"") != line.npos) {
      auto started = std::chrono::steady_clock::now();
      double dt = numbers(line, "dt")[0];
      for (size_t row = 0; row < states.size(); row += 13)
        for (int n = int(numbers(line, "n")[0]); n > 0; n--) step(&states[row], moments, gravity, dt);
      std::chrono::duration<double, std::nano> took = std::chrono::steady_clock::now() - started;
      answer = "{\"ns\": " + std::to_string(took.count()) + "}";
    }
    if (line.find("\"read\"") != line.npos) {
      answer = "{\"states\": [";
      for (size_t i = 0; i < states.size(); i++) {
        char text[32] = "null";
        if (std::isfinite(states[i])) std::snprintf(text, sizeof text, "%.17g", states[i]);
        answer += (i % 13 ? ", " : i ? "], [" : "[") + std::string(text);
      }
      answer += "]]}";
    }
    std::cout << answer << std::endl;
  }
}
