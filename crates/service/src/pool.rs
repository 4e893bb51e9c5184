//! A pool of children that read and judge, so that this process never reads what was uploaded.
//!
//! Each place of the pool is a thread that drives one child over pipes: an order goes in, with the
//! recording's files if the child does not hold them; beats and one answer come out. A child that
//! ends, is late or breaks the protocol is replaced, and its order answered with [`Lost`].
//!
//! - `words`: messages between parent and child;
//! - `frame`: framing of messages;
//! - `child`: the child's side: the loop of a worker;
//! - `answer`: a child's answer to each order;
//! - `trials`: trials of a child against its jail;
//! - `slot`: the parent's side: one child, driven;
//! - `orders`: orders that wait, in turn by owner;
//! - `crew`: all places, their orders, and the jobs of the ledger.

mod answer;
mod child;
mod crew;
mod frame;
mod orders;
mod slot;
mod trials;
mod words;

pub(crate) use answer::{design_of, request_of};
pub use child::work as child_work;
pub use crew::{ANSWERS, Crew, CrewOptions, OwnerFigures, Progress, WAITING};
pub use orders::{HeldFirst, Orders};
pub use slot::{ChildOptions, Delivered, Ending, Lost, Slot};
pub use words::{Answer, Beat, FirstAnswer, How, Order, Step, Trial};
