//! Draws: a counter-based generator and the normal distribution, truncated or whole.
//!
//! A draw is a function of seed, member and parameter alone. So member i is the same however
//! many members there are and whichever thread makes it, and a tolerance that is added to a
//! design leaves the draws of the others as they were.

/// Name of the generator, as verdicts state it.
pub const GENERATOR: &str = "philox4x32-10, key = seed, counter = (member, parameter); normal by inverse distribution (AS 241), truncated at 3 standard deviations";

/// The same where the normal distribution is not cut.
pub const GENERATOR_OF_WHOLE: &str = "philox4x32-10, key = seed, counter = (member, parameter); normal by inverse distribution (AS 241), not truncated";

/// Standard deviations at which the normal distribution is cut.
pub const TRUNCATION: f64 = 3.0;

/// Φ(−3), the share of a normal distribution below the cut.
const BELOW_CUT: f64 = 1.349_898_031_630_094_5e-3;

/// Returns the four words of Philox 4×32 with ten rounds.
///
/// # Source
///
/// J. K. Salmon et al., Parallel random numbers: as easy as 1, 2, 3, SC '11, section 3.3.
pub fn philox(mut counter: [u32; 4], mut key: [u32; 2]) -> [u32; 4] {
    const MULTIPLIERS: [u64; 2] = [0xD251_1F53, 0xCD9E_8D57];
    const WEYL: [u32; 2] = [0x9E37_79B9, 0xBB67_AE85];
    for _ in 0..10 {
        let [high_0, low_0] = halves(MULTIPLIERS[0] * u64::from(counter[0]));
        let [high_1, low_1] = halves(MULTIPLIERS[1] * u64::from(counter[2]));
        counter = [
            high_1 ^ counter[1] ^ key[0],
            low_1,
            high_0 ^ counter[3] ^ key[1],
            low_0,
        ];
        key = [key[0].wrapping_add(WEYL[0]), key[1].wrapping_add(WEYL[1])];
    }
    counter
}

/// Upper and lower half of a word.
fn halves(word: u64) -> [u32; 2] {
    [(word >> 32) as u32, word as u32]
}

/// Returns a number between 0 and 1, neither of them reached, from 52 bits.
pub fn uniform(seed: u64, member: u32, parameter: u32) -> f64 {
    let [high, low] = halves(seed);
    let words = philox([member, parameter, 0, 0], [low, high]);
    let bits = (u64::from(words[0]) << 20) | u64::from(words[1] >> 12);
    let place = bits as f64 + 0.5;
    place / 4_503_599_627_370_496.0
}

/// Returns a draw of the standard normal distribution truncated at ±3.
pub fn truncated_normal(seed: u64, member: u32, parameter: u32) -> f64 {
    let inside = 1.0 - 2.0 * BELOW_CUT;
    let share = BELOW_CUT + uniform(seed, member, parameter) * inside;
    inverse_normal(share).clamp(-TRUNCATION, TRUNCATION)
}

/// Returns a draw of the standard normal distribution; NaN of the one in 10¹⁰ beyond 6.6 standard deviations.
pub fn normal(seed: u64, member: u32, parameter: u32) -> f64 {
    inverse_normal(uniform(seed, member, parameter))
}

/// Returns the value below which a normal distribution has the share `p` [-].
///
/// Its relative error is below 1e-15 (a few units in the last place) for p from 1.4e-11 to
/// 1 − 1.4e-11; nearer 0 and 1 the tails of the source are left out, since no draw gets there,
/// and NaN is returned.
///
/// # Source
///
/// M. J. Wichura, Algorithm AS 241, Applied Statistics 37 (1988), routine PPND16.
pub fn inverse_normal(p: f64) -> f64 {
    const CENTRE_ABOVE: [f64; 8] = [
        3.387_132_872_796_366_5,
        1.331_416_678_917_843_8e2,
        1.971_590_950_306_551_3e3,
        1.373_169_376_550_946e4,
        4.592_195_393_154_987e4,
        6.726_577_092_700_87e4,
        3.343_057_558_358_813e4,
        2.509_080_928_730_122_7e3,
    ];
    const CENTRE_BELOW: [f64; 8] = [
        1.0,
        4.231_333_070_160_091e1,
        6.871_870_074_920_579e2,
        5.394_196_021_424_751e3,
        2.121_379_430_158_659_7e4,
        3.930_789_580_009_271e4,
        2.872_908_573_572_194_3e4,
        5.226_495_278_852_854e3,
    ];
    const SIDE_ABOVE: [f64; 8] = [
        1.423_437_110_749_683_5,
        4.630_337_846_156_546,
        5.769_497_221_460_691,
        3.647_848_324_763_204_5,
        1.270_458_252_452_368_4,
        2.417_807_251_774_506e-1,
        2.272_384_498_926_918_4e-2,
        7.745_450_142_783_414e-4,
    ];
    const SIDE_BELOW: [f64; 8] = [
        1.0,
        2.053_191_626_637_759,
        1.676_384_830_183_803_8,
        6.897_673_349_851e-1,
        1.481_039_764_274_800_8e-1,
        1.519_866_656_361_645_7e-2,
        5.475_938_084_995_345e-4,
        1.050_750_071_644_416_9e-9,
    ];
    let nested =
        |coefficients: &[f64; 8], x: f64| coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c);
    let q = p - 0.5;
    if q.abs() <= 0.425 {
        let r = 0.180_625 - q * q;
        return q * nested(&CENTRE_ABOVE, r) / nested(&CENTRE_BELOW, r);
    }
    let tail = if q < 0.0 { p } else { 1.0 - p };
    let r = (-libm::log(tail)).sqrt();
    // Beyond 5, and for what is no share at all, NaN.
    if !(tail > 0.0 && r <= 5.0) {
        return f64::NAN;
    }
    let value = nested(&SIDE_ABOVE, r - 1.6) / nested(&SIDE_BELOW, r - 1.6);
    if q < 0.0 { -value } else { value }
}
