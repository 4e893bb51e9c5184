//! Words for gravity in an acceleration, as an accelerometer at rest measures it.

use super::words;
use crate::words::{Words, word_list};

// The head of each list explains it.
static GRAVITY: Words = word_list!("name-gravity");
static WITH: Words = word_list!("name-gravity-with");
static WITHOUT: Words = word_list!("name-gravity-without");
static NEGATIONS: Words = word_list!("name-negations");

/// True if a name or a comment says that gravity is in the samples: `including gravity`, `with g`,
/// `mit Erdbeschleunigung`, `specific force`.
pub(crate) fn says_gravity(text: &str) -> bool {
    // The message of ROS whose accelerations include gravity.
    let small = text.to_lowercase();
    if ["sensor_msgs/imu", "sensor_msgs/msg/imu"]
        .iter()
        .any(|name| small.contains(name))
    {
        return true;
    }
    let words = words(text);
    let listed = |list: &Words, word: &String| list.contains(&word.as_str());
    let pair = |pair: &[String]| match pair {
        [with, noun] => {
            (listed(&WITH, with) && noun == "g")
                || (with == "specific" && noun == "force")
                || (with == "proper" && noun.starts_with("accel"))
        }
        _ => false,
    };
    let says = words.iter().any(|word| listed(&GRAVITY, word)) || words.windows(2).any(pair);
    let without = |word: &String| listed(&WITHOUT, word) || listed(&NEGATIONS, word);
    says && !words.iter().any(without)
}
