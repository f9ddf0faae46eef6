// The 2-D Vicsek model as one writes it in C++ by hand: what the compiled rules are measured against.
//
// float64, one thread, periodic square of at least three cells a side. Cells of a side >= r are
// filled by a counting sort each tick, and agents stay in that order; a half stencil looks at each
// pair once. The noise is angular, from a hash of (seed, tick, agent).

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace {

struct Columns {
  std::vector<double> x, y, ux, uy;  // position (length) and heading (unit vector)
  std::vector<int64_t> id;

  explicit Columns(int64_t n) : x(n), y(n), ux(n), uy(n), id(n) {}
};

uint64_t mixed(uint64_t z) {  // the finaliser of SplitMix64
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

// Uniform in [-1/2, 1/2).
double centred(uint64_t key, int64_t id) {
  return static_cast<double>(mixed(key + static_cast<uint64_t>(id) * 0x9E3779B97F4A7C15u) >> 11) *
             0x1p-53 - 0.5;
}

class Flock {
 public:
  Flock(int64_t n, double side, double r)
      : n(n), cells(static_cast<int64_t>(side / r)), side(side), r2(r * r), now(n), sorted(n),
        sum_x(n), sum_y(n), cell(n), first(cells * cells + 1) {}

  void tick(double v0, double eta, uint64_t key) {
    sort();
    add_pairs();
    move(v0, eta, key);
  }

  const int64_t n, cells;
  const double side, r2;
  Columns now;

 private:
  Columns sorted;
  std::vector<double> sum_x, sum_y;  // of the headings of all neighbours
  std::vector<int32_t> cell;
  std::vector<int32_t> first;  // of each cell, its first agent

  void sort() {
    const double per = cells / side;
    const int32_t last = static_cast<int32_t>(cells - 1);
    std::fill(first.begin(), first.end(), 0);
    for (int64_t i = 0; i < n; ++i) {
      const int32_t column = std::min(static_cast<int32_t>(now.x[i] * per), last);
      const int32_t row = std::min(static_cast<int32_t>(now.y[i] * per), last);
      cell[i] = row * static_cast<int32_t>(cells) + column;
    }
    for (int64_t i = 0; i < n; ++i) ++first[cell[i] + 1];
    for (size_t c = 1; c < first.size(); ++c) first[c] += first[c - 1];
    for (int64_t i = n - 1; i >= 0; --i) {
      const int32_t k = --first[cell[i] + 1];  // afterwards first[c + 1] is where c begins
      sorted.x[k] = now.x[i];
      sorted.y[k] = now.y[i];
      sorted.ux[k] = now.ux[i];
      sorted.uy[k] = now.uy[i];
      sorted.id[k] = now.id[i];
    }
    std::copy(first.begin() + 1, first.end(), first.begin());
    first.back() = static_cast<int32_t>(n);
    std::swap(now, sorted);
  }

  // Agent i with those from `begin` to `end`, which are seen displaced by (shift_x, shift_y).
  void add(int64_t i, int64_t begin, int64_t end, double shift_x, double shift_y) {
    const double* __restrict x = now.x.data();
    const double* __restrict y = now.y.data();
    const double* __restrict ux = now.ux.data();
    const double* __restrict uy = now.uy.data();
    double* __restrict sx = sum_x.data();
    double* __restrict sy = sum_y.data();
    const double xi = x[i] - shift_x, yi = y[i] - shift_y, uxi = ux[i], uyi = uy[i], rr = r2;
    double ax = 0.0, ay = 0.0;
    for (int64_t j = begin; j < end; ++j) {
      const double dx = x[j] - xi, dy = y[j] - yi;
      const double a = dx * dx + dy * dy <= rr ? 1.0 : 0.0;
      ax += a * ux[j];
      ay += a * uy[j];
      sx[j] += a * uxi;
      sy[j] += a * uyi;
    }
    sx[i] += ax;
    sy[i] += ay;
  }

  void add_pairs() {
    sum_x = now.ux;
    sum_y = now.uy;
    for (int64_t row = 0; row < cells; ++row) {
      const int64_t above = row + 1 < cells ? row + 1 : 0;
      const double up = row + 1 < cells ? 0.0 : side;
      const int32_t* own = &first[row * cells];
      const int32_t* next = &first[above * cells];
      for (int64_t column = 0; column < cells; ++column) {
        const bool left = column == 0, right = column + 1 == cells;
        const int64_t from = next[left ? 0 : column - 1];
        const int64_t to = next[right ? column + 1 : column + 2];
        const int64_t east = own[right ? column + 1 : column + 2];
        for (int64_t i = own[column]; i < own[column + 1]; ++i) {
          add(i, i + 1, east, 0.0, 0.0);
          add(i, from, to, 0.0, up);
          if (left) add(i, next[cells - 1], next[cells], -side, up);
          if (right) {
            add(i, own[0], own[1], side, 0.0);
            add(i, next[0], next[1], side, up);
          }
        }
      }
    }
  }

  void move(double v0, double eta, uint64_t key) {
    for (int64_t i = 0; i < n; ++i) {
      const double angle = eta * centred(key, now.id[i]);
      const double c = std::cos(angle), s = std::sin(angle);
      const double norm = std::sqrt(sum_x[i] * sum_x[i] + sum_y[i] * sum_y[i]);
      const double wx = norm > 0.0 ? sum_x[i] / norm : now.ux[i];
      const double wy = norm > 0.0 ? sum_y[i] / norm : now.uy[i];
      now.ux[i] = c * wx - s * wy;
      now.uy[i] = s * wx + c * wy;
      now.x[i] = wrapped(now.x[i] + v0 * now.ux[i]);
      now.y[i] = wrapped(now.y[i] + v0 * now.uy[i]);
    }
  }

  double wrapped(double x) const {
    x = x < 0.0 ? x + side : x;
    return x >= side ? x - side : x;
  }
};

}  // namespace

// So many ticks; position, length, and heading, a unit vector, are columns of n and written to.
extern "C" void run(int64_t n, double side, double r, double v0, double eta, uint64_t seed,
                    int64_t ticks, double* x, double* y, double* ux, double* uy) {
  Flock flock(n, side, r);
  for (int64_t i = 0; i < n; ++i) {
    flock.now.x[i] = x[i];
    flock.now.y[i] = y[i];
    flock.now.ux[i] = ux[i];
    flock.now.uy[i] = uy[i];
    flock.now.id[i] = i;
  }
  for (int64_t t = 0; t < ticks; ++t) flock.tick(v0, eta, mixed(seed + mixed(t)));
  for (int64_t k = 0; k < n; ++k) {
    const int64_t i = flock.now.id[k];
    x[i] = flock.now.x[k];
    y[i] = flock.now.y[k];
    ux[i] = flock.now.ux[k];
    uy[i] = flock.now.uy[k];
  }
}
