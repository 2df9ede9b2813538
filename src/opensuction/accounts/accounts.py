"""Operations on people's accounts, as a console or a command calls them."""

from collections.abc import Iterable
from datetime import timedelta

from opensuction.accounts import access_token, directory, session, sign_in
from opensuction.accounts.access_token import NewToken
from opensuction.accounts.directory import Account, NewPassword
from opensuction.accounts.password_hash import PasswordHasher
from opensuction.accounts.session import AccessToken, Session
from opensuction.accounts.sign_in import SignedIn
from opensuction.accounts.site import AccountStore
from opensuction.records.database import utc_time
from opensuction.records.database.database import Database
from opensuction.records.records import Clock


class Accounts:
    """The accounts of one database; may be used by several threads, and by several programs.

    What each call raises is said where it is carried out; all of it is one plain line: errors of
    `refusal` for a person who may not, InputError for what cannot be, RecordsError of the database.
    """

    def __init__(
        self,
        database: Database,
        clock: Clock = utc_time.now,
        hasher: PasswordHasher | None = None,
    ) -> None:
        """Of a database that is up to date (`Records.open`)."""
        self._site = AccountStore(database, clock, hasher or PasswordHasher())

    def first_start(self) -> NewPassword | None:
        """Make an administrator where there is no account (`directory.first_start`)."""
        return directory.first_start(self._site)

    def sign_in(self, name: str, password: str, origin: str, device: str | None = None) -> SignedIn:
        """Sign somebody in (`sign_in.sign_in`)."""
        return sign_in.sign_in(self._site, name, password, origin, device)

    def sign_out(self, token: str) -> None:
        """End a session; one that is over already is no error."""
        sign_in.sign_out(self._site, token)

    def find_session(self, token: str) -> Session:
        """Session of a token, as of now, for a request that changes nothing."""
        return session.find(self._site, token)

    def check_session(self, token: str) -> Session:
        """As `find_session`, where nobody asks for anything: it does not go on for that."""
        return session.find(self._site, token, goes_on=False)

    def find_session_for_change(self, token: str, csrf: str | None) -> Session:
        """As `find_session`, for a request that changes something. csrf: what the page shows."""
        session.check_csrf(token, csrf or "")
        return session.find(self._site, token)

    def change_password(self, token: str, present: str, wanted: str) -> Session:
        """Change one's own password; all other sessions of the account end."""
        return sign_in.change_password(self._site, token, present, wanted)

    def list_accounts(self) -> list[Account]:
        """All accounts, by their names."""
        return directory.list_accounts(self._site)

    def add(
        self, by: Session | None, name: str, role: str, is_administrator: bool = False
    ) -> NewPassword:
        """Make an account. by: the administrator; None: a command on the machine itself."""
        return directory.add(self._site, by, name, role, is_administrator)

    def change_role(
        self, by: Session | None, name: str, role: str, is_administrator: bool, reason: str
    ) -> None:
        """Change what an account may do, from its next request on."""
        directory.change_role(self._site, by, name, role, is_administrator, reason)

    def deactivate(self, by: Session | None, name: str, reason: str) -> None:
        """Nobody signs in as this account any more; its sessions end."""
        directory.deactivate(self._site, by, name, reason)

    def reset_password(self, by: Session | None, name: str) -> NewPassword:
        """Make a one-time password; an account that was deactivated is there again."""
        return directory.reset_password(self._site, by, name)

    def issue_token(
        self, by: Session | None, label: str, scope: Iterable[str], life: timedelta
    ) -> NewToken:
        """Make a token for another program, which only reads."""
        return access_token.issue(self._site, by, label, scope, life)

    def find_token(self, token: str) -> AccessToken:
        """Access that a token gives; see `access_token.find`."""
        return access_token.find(self._site, token)

    def revoke_token(self, by: Session | None, token_id: str) -> None:
        """End a token."""
        access_token.revoke(self._site, by, token_id)

    def list_tokens(self) -> list[AccessToken]:
        """Tokens that hold, by their labels."""
        return access_token.list_tokens(self._site)
