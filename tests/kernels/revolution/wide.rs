//! Numbers of 106 bits: unevaluated sums of two f64 (Dekker 1971).

use std::ops::{Add, Mul, Neg, Sub};

/// What the oracle computes with.
pub trait Number: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    /// Bounds the error of a sum relative to its terms' sizes, and of a product relative to
    /// itself.
    const ROUNDING: f64;
    fn of(value: f64) -> Self;
    fn value(self) -> f64;
}

impl Number for f64 {
    const ROUNDING: f64 = f64::EPSILON;

    fn of(value: f64) -> Self {
        value
    }

    fn value(self) -> f64 {
        self
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Wide {
    high: f64,
    low: f64,
}

impl Wide {
    /// The sum of two f64, exactly (Knuth).
    pub fn sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let of_b = high - a;
        Self { high, low: (a - (high - of_b)) + (b - of_b) }
    }

    /// The same where |a| >= |b|.
    fn ordered_sum(a: f64, b: f64) -> Self {
        let high = a + b;
        Self { high, low: b - (high - a) }
    }

    /// The product of two f64, exactly.
    pub fn product(a: f64, b: f64) -> Self {
        let high = a * b;
        Self { high, low: a.mul_add(b, -high) }
    }

    pub fn over(self, divisor: f64) -> Self {
        let high = self.high / divisor;
        let rest = self - Self::product(high, divisor);
        Self::ordered_sum(high, rest.high / divisor)
    }
}

impl Number for Wide {
    const ROUNDING: f64 = 8.0 * f64::EPSILON * f64::EPSILON;

    fn of(value: f64) -> Self {
        Self { high: value, low: 0.0 }
    }

    fn value(self) -> f64 {
        self.high
    }
}

impl Add for Wide {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let sum = Self::sum(self.high, other.high);
        Self::ordered_sum(sum.high, sum.low + (self.low + other.low))
    }
}

impl Neg for Wide {
    type Output = Self;

    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}

impl Sub for Wide {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Wide {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let product = Self::product(self.high, other.high);
        Self::ordered_sum(product.high, product.low + (self.high * other.low + self.low * other.high))
    }
}
