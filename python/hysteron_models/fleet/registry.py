"""The registry: what was calibrated, one transaction a result, in SQLite or PostgreSQL."""

from __future__ import annotations

import os
import sqlite3
from pathlib import Path
from typing import Any

from alembic.config import Config
from alembic.runtime.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import Connection, Engine, create_engine, delete, event, make_url, select
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.engine.interfaces import DBAPIConnection
from sqlalchemy.exc import ArgumentError, DatabaseError, NoSuchModuleError, OperationalError

from .._errors import OptionError, RegistryError, missing
from ..record import PathLike
from .schema import calibrations, devices, parameters
from .work import Outcome

MIGRATIONS = Path(__file__).parent / "migrations"
# For another program that writes [s].
BUSY_S = 30.0


class Registry:
    """Devices, their calibrations and the parameters of these.

    The file is made where it is missing, and brought to the newest schema. One program writes at a time;
    SQLite files belong on a local disk.

    Args:
        url: ``sqlite:///fleet.sqlite``, ``postgresql+psycopg://user@host/fleet``, or the path of a SQLite
            file.

    Raises:
        RegistryError: no registry, or one of a newer version of this program.
    """

    def __init__(self, url: str | PathLike = "sqlite:///fleet.sqlite") -> None:
        text = os.fspath(url)
        self.url = text if "://" in text else f"sqlite:///{text}"
        self.engine = _engine(self.url)
        try:
            with self.engine.execution_options(writes=True).begin() as connection:
                _upgrade(connection, self.url)
        except DatabaseError as error:
            raise RegistryError(f"{self.shown}: {error.orig}", code="registry") from error

    @property
    def shown(self) -> str:
        """The URL without its password."""
        return make_url(self.url).render_as_string(hide_password=True)

    def __repr__(self) -> str:
        return f"<Registry {self.shown}>"

    def keep(self, rows: list[tuple[dict[str, Any], dict[str, Any], Outcome]]) -> None:
        """Write calibrations in one transaction: of each the device, the columns that the client knows, and
        the outcome. A row of the same device and key is replaced."""
        with self.engine.execution_options(writes=True).begin() as connection:
            for device, known, outcome in rows:
                _keep(connection, device, known, outcome)

    def describe(self, device: dict[str, Any], key: str, known: dict[str, Any]) -> None:
        """Bring serial number, date, operator and notes of a calibration up to date."""
        with self.engine.execution_options(writes=True).begin() as connection:
            own = _device_id(connection, device)
            at = (calibrations.c.device_id == own) & (calibrations.c.key == key)
            connection.execute(calibrations.update().where(at).values(**known))

    def close(self) -> None:
        """Close the connections."""
        self.engine.dispose()

    def __enter__(self) -> Registry:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def opened(registry: Registry | str | PathLike) -> Registry:
    """The registry, or that at a URL."""
    return registry if isinstance(registry, Registry) else Registry(registry)


def _engine(url: str) -> Engine:
    try:
        parsed = make_url(url)
        backend = parsed.get_backend_name()
        if backend not in ("sqlite", "postgresql"):
            raise OptionError(
                f"registry: expected sqlite:///… or postgresql+psycopg://…, found {backend}", code="url"
            )
        engine = create_engine(parsed, pool_pre_ping=backend == "postgresql")
    except ModuleNotFoundError as error:
        raise missing(error.name or "psycopg", "postgres", "a registry in PostgreSQL") from None
    except (ArgumentError, NoSuchModuleError) as error:
        raise OptionError(f"registry: {error}", code="url") from None
    if backend == "sqlite":
        event.listen(engine, "connect", _connected)
        event.listen(engine, "begin", _begun)
    return engine


def _connected(connection: DBAPIConnection, _: object) -> None:
    if isinstance(connection, sqlite3.Connection):
        # Transactions are begun below: the driver's own would leave out changes of the schema.
        connection.isolation_level = None
    cursor = connection.cursor()
    cursor.execute("PRAGMA foreign_keys = ON")
    cursor.execute(f"PRAGMA busy_timeout = {int(1000 * BUSY_S)}")
    cursor.close()


def _begun(connection: Connection) -> None:
    writes = connection.get_execution_options().get("writes", False)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")


def _upgrade(connection: Connection, url: str) -> None:
    """Bring the schema to the newest revision, within the transaction of the connection."""
    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS).replace("%", "%%"))
    config.attributes["connection"] = connection
    scripts = ScriptDirectory.from_config(config)
    context = MigrationContext.configure(connection)
    current, head = context.get_current_revision(), scripts.get_current_head()
    if current == head:
        return
    if current is not None and current not in {script.revision for script in scripts.walk_revisions()}:
        raise RegistryError(
            f"{make_url(url).render_as_string()} has schema {current}; this version knows up to {head}",
            code="newer-schema",
            hint="update hysteron-models",
        )
    if current is None and connection.dialect.has_table(connection, "calibrations"):
        raise RegistryError(
            f"{make_url(url).render_as_string()} has tables of another program", code="no-registry"
        )
    from alembic import command

    command.upgrade(config, "head")


def _insert(connection: Connection, table: Any) -> Any:
    return (sqlite if connection.dialect.name == "sqlite" else postgresql).insert(table)


def _device_id(connection: Connection, device: dict[str, Any]) -> int:
    made = _insert(connection, devices).values(**device)
    # An unchanged row is written too, so that its number is returned.
    given = {"serial": made.excluded.serial} if device.get("serial") else {"name": made.excluded.name}
    made = made.on_conflict_do_update(index_elements=[devices.c.name], set_=given)
    return int(connection.execute(made.returning(devices.c.id)).scalar_one())


def _keep(connection: Connection, device: dict[str, Any], known: dict[str, Any], outcome: Outcome) -> None:
    own = _device_id(connection, device)
    # A failure of the machine is history once the same record was calibrated.
    stale = (
        (calibrations.c.device_id == own)
        & (calibrations.c.paths == known["paths"])
        & (calibrations.c.cause == "machine")
    )
    old = connection.execute(select(calibrations.c.id).where(stale)).scalars().all()
    for number in old:
        connection.execute(delete(parameters).where(parameters.c.calibration_id == number))
    connection.execute(delete(calibrations).where(stale))
    row = {"device_id": own, **known, **outcome.row()}
    made = _insert(connection, calibrations).values(**row)
    changed = {name: made.excluded[name] for name in row if name not in ("device_id", "key")}
    made = made.on_conflict_do_update(
        index_elements=[calibrations.c.device_id, calibrations.c.key], set_=changed
    )
    number = connection.execute(made.returning(calibrations.c.id)).scalar_one()
    connection.execute(delete(parameters).where(parameters.c.calibration_id == number))
    if outcome.parameters:
        numbered = [{"calibration_id": number, "position": k, **p} for k, p in enumerate(outcome.parameters)]
        connection.execute(parameters.insert(), numbered)


__all__ = ["OperationalError", "Registry", "opened"]
