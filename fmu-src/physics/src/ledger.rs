//! Power balance: each power flow is entered once, with its source and its sink.
//!
//! A flow leaves one account and enters another, so the sum over all accounts is always zero. The
//! accounts of a motor are the external flows that can be measured ([`Account::Terminals`],
//! [`Account::Shaft`], [`Account::Ambient`]), the energy storages, and [`Account::AirGap`], which stores
//! nothing. The check is that the model's own derivatives agree with the accounts ([`Ledger::error`]).

/// Source or sink of energy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Account {
    /// Electrical terminals, and external heat input.
    Terminals,
    /// The load on the shaft.
    Shaft,
    /// Ambient.
    Ambient,
    /// Magnetic energy of the current, L I^2 / 2.
    Magnetic,
    /// Kinetic energy of the rotor, J w^2 / 2.
    Kinetic,
    /// Conversion between electrical and mechanical power; stores nothing.
    AirGap,
    /// Heat in the winding.
    Winding,
    /// Heat in the stator, where it has its own temperature.
    Stator,
    /// Heat in the rotor with its magnets, where it has its own temperature.
    Rotor,
    /// Heat in the tube around the motor.
    Tube,
    /// Air flow past the motor; stores nothing.
    Air,
    /// The electrical supply of the fan.
    Fan,
    /// Heat in the housing, with stator and magnets where they have no own account.
    Housing,
    /// The joint that an actuator moves.
    Joint,
    /// Energy of the springs.
    Spring,
    /// Heat in a node of a model that lists its nodes, by its index, below [`MOST_NODES`].
    Node(usize),
}

/// Largest number of listed nodes.
pub const MOST_NODES: usize = 8;
const ACCOUNTS: usize = Account::Node(MOST_NODES).index();

impl Account {
    const fn index(self) -> usize {
        match self {
            Account::Terminals => 0,
            Account::Shaft => 1,
            Account::Ambient => 2,
            Account::Magnetic => 3,
            Account::Kinetic => 4,
            Account::AirGap => 5,
            Account::Winding => 6,
            Account::Stator => 7,
            Account::Rotor => 8,
            Account::Tube => 9,
            Account::Air => 10,
            Account::Fan => 11,
            Account::Housing => 12,
            Account::Joint => 13,
            Account::Spring => 14,
            Account::Node(node) => 15 + node,
        }
    }
}

/// Flows at one instant, W.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ledger {
    net: [f64; ACCOUNTS],
}

impl Ledger {
    /// Enters a flow of `power` watts from one account to another.
    pub fn transfer(&mut self, from: Account, to: Account, power: f64) {
        self.net[from.index()] -= power;
        self.net[to.index()] += power;
    }

    /// Power into an account, W.
    pub fn gain(&self, account: Account) -> f64 {
        self.net[account.index()]
    }

    /// Power balance residual, W: the sum over all accounts of the magnitude of the difference between the entered power and
    /// the account's own value in `shown` (terminal voltage times current, heat capacity times temperature derivative, ...).
    pub fn error(&self, shown: &[(Account, f64)]) -> f64 {
        shown.iter().map(|&(account, gain)| (self.gain(account) - gain).abs()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_one_account_loses_another_gains() {
        let mut ledger = Ledger::default();
        ledger.transfer(Account::Terminals, Account::Winding, 10.0);
        ledger.transfer(Account::Winding, Account::Housing, 4.0);
        assert_eq!(ledger.gain(Account::Terminals), -10.0);
        assert_eq!(ledger.gain(Account::Winding), 6.0);
        assert_eq!(ledger.net.iter().sum::<f64>(), 0.0);
    }

    #[test]
    fn an_account_that_shows_something_else_is_an_error() {
        let mut ledger = Ledger::default();
        ledger.transfer(Account::Terminals, Account::Winding, 10.0);
        let error = ledger.error(&[(Account::Terminals, -10.0), (Account::Winding, 9.75)]);
        assert_eq!(error, 0.25);
    }
}
